#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "core/geometry/camera.h"

namespace rigcal {

/// JSON for people and for diff: objects indented by two spaces, arrays of plain values on one line, keys in the order
/// of insertion, every number with the digits it takes to read back the same double. All numbers must be finite.
std::string JsonText(const nlohmann::ordered_json& document);

/// Whether a JSON document can hold the text.
bool IsUtf8(const std::string& text);

/// A number that may not exist (an error without any track) is null in JSON.
nlohmann::ordered_json NumberJson(double number);

/// Keys of the intrinsics in every JSON file, in the order of IntrinsicIndex.
inline constexpr std::array<const char*, kNumIntrinsics> kIntrinsicKeys = {
    "fx_px", "fy_px", "cx_px", "cy_px", "skew_px", "k1", "k2", "p1", "p2", "k3"};

/// {"fx_px": ..., ...}
nlohmann::ordered_json IntrinsicsJson(const IntrinsicVector& intrinsics);

}  // namespace rigcal
