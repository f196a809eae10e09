#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/scene/recording.h"
#include "core/scene/rig_model.h"

namespace rigcal {

/// Its usual name.
inline constexpr const char* kRigFile = "rig.toml";

/// rig.toml: the studio's positioner and how exactly it repeats (docs/rig.md).
struct RigFile {
  RigModel model;                 ///< kind, load and expected errors; geometry is for seeding to find
  std::vector<std::string> axes;  ///< their names in recordings; none for an arm
};

/// `file` names it in messages, which tell line, key and allowed range. Errors: kBadInput: not TOML, a key that is
/// unknown, missing or not one of this kind of positioner, a value of the wrong type or out of range.
Result<RigFile> ParseRig(std::string_view text, const std::string& file);

/// The text of a rig.toml with every key. Reads back as the same rig but for the twelfth digit.
std::string RigText(const RigFile& rig);

/// Where the positioner stood at each stop of a recording: as reported, or as commanded where it does not report.
/// `recording_name` names it in messages. Errors: kBadInput with the stop: an axis of the rig or an arm's pose is
/// missing, or in another unit.
Result<std::vector<StopPosition>> StopPositions(const Recording& recording, const RigFile& rig,
                                                const std::string& recording_name);

}  // namespace rigcal
