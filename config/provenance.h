#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/read_file.h"

namespace rigcal {

/// Everything that is needed to repeat a run. Holds no date, host name or folder: the same run writes the same.
struct Provenance {
  std::string program_version;
  std::string method;                                        ///< "rigcal", "paper", "export", ...
  std::vector<std::pair<std::string, std::string>> options;  ///< as given, in a fixed order
  std::uint64_t random_seed = 0;
  std::vector<InputFile> inputs;
  std::vector<std::string> notes;
};

/// The program's version, "0.1.0".
std::string_view ProgramVersion();

}  // namespace rigcal
