#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace rigcal {

/// A file that went into a run: enough to tell later whether it is still the same.
struct InputFile {
  std::string name;    ///< without its folder, so that the same run elsewhere writes the same
  std::string sha256;  ///< 64 hexadecimal digits
};

/// All bytes of a file. Errors: kNotFound, kIo.
Result<std::string> ReadFile(const std::filesystem::path& path);

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string Sha256Hex(const std::string& bytes);

/// Whether `file` is still the one that a recording lists. Errors: kBadInput with the beginnings of both checksums.
Result<void> CheckSha256(const std::string& actual, const std::string& recorded, const std::string& file);

}  // namespace rigcal
