#pragma once

#include <string>

namespace rigcal {

/// As syslog and the journal count.
enum class LogPriority { kError = 3, kWarning = 4, kNotice = 5, kInformation = 6 };

/// One line on stderr: with the priority before it where the journal reads it, with the program's name where a person
/// does. From any thread; a line is whole.
void Log(LogPriority priority, const std::string& sentence);

}  // namespace rigcal
