#pragma once

#include <nlohmann/json.hpp>

#include "config/provenance.h"

namespace rigcal {

/// The key "provenance" of a calibration.json (docs/formats.md).
nlohmann::ordered_json ProvenanceJson(const Provenance& provenance);
/// Back. Throws BadContent and what the library throws.
Provenance ProvenanceFrom(const nlohmann::ordered_json& json);

}  // namespace rigcal
