#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "core/scene/rig_model.h"

namespace rigcal {

/// Words of rig.toml and calibration.json.
inline constexpr std::array<std::pair<std::string_view, PositionerKind>, 3> kPositionerKinds = {{
    {"turntable", PositionerKind::kTurntable},
    {"gantry", PositionerKind::kGantry},
    {"arm", PositionerKind::kArm},
}};
inline constexpr std::array<std::pair<std::string_view, PositionerLoad>, 2> kPositionerLoads = {{
    {"object", PositionerLoad::kObject},
    {"cameras", PositionerLoad::kCameras},
}};

}  // namespace rigcal
