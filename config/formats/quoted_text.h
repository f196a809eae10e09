#pragma once

#include <string>
#include <string_view>

namespace rigcal {

/// A word in double quotes as JSON and YAML read it. The word is UTF-8.
std::string Quoted(const std::string& word);

/// A word between the quotes of an XML attribute.
std::string XmlQuoted(std::string_view word);

}  // namespace rigcal
