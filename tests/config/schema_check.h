#pragma once

#include <string>

namespace rigcal {

/// What docs/schema/NAME has against the text of a JSON document; empty when nothing.
std::string SchemaComplaints(const std::string& schema_name, const std::string& text);

}  // namespace rigcal
