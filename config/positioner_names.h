#pragma once

#include <array>
#include <optional>
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

/// The word for a value of one of these lists.
template <typename Value, std::size_t kCount>
std::string_view WordOf(const std::array<std::pair<std::string_view, Value>, kCount>& words, Value value) {
  for (const auto& [word, known] : words) {
    if (known == value) return word;
  }
  return "";
}

/// The value of a word of one of these lists; nothing for another word.
template <typename Value, std::size_t kCount>
std::optional<Value> FromWord(const std::array<std::pair<std::string_view, Value>, kCount>& words,
                              std::string_view given) {
  for (const auto& [word, value] : words) {
    if (word == given) return value;
  }
  return std::nullopt;
}

}  // namespace rigcal
