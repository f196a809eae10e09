#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace rigcal {

/// A line of a text file with the number that an editor shows for it (from 1).
struct TextLine {
  int number = 0;
  std::string_view text;
};

/// All lines, also empty ones, without their line ends (LF or CRLF). Views into `text`.
std::vector<TextLine> SplitLines(std::string_view text);

/// The fields of a line, separated by spaces or tabs. Views into `line`.
std::vector<std::string_view> SplitFields(std::string_view line);

/// `text` without spaces, tabs and carriage returns at its ends.
std::string_view Trimmed(std::string_view text);

/// The fields as finite numbers, whatever the locale. `where` ("cams.txt line 3") starts the message of an Error.
Result<std::vector<double>> ParseNumbers(std::span<const std::string_view> fields, const std::string& where);

/// A field as a whole number in [0, 2^31).
Result<int> ParseCount(std::string_view field, const std::string& where);

}  // namespace rigcal
