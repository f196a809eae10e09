#include "config/read_file.h"

#include <openssl/evp.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>

#include "core/base/ensure.h"

namespace rigcal {

Result<std::string> ReadFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return Fail(ErrorCode::kNotFound, "{}: there is no such file", path.string());
  if (std::filesystem::is_directory(path, error))
    return Fail(ErrorCode::kBadInput, "{}: a file is needed here, this is a folder", path.string());
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream bytes;
  // Copying an empty file sets failbit on the target; that is no failure of reading.
  if (stream && stream.peek() != std::ifstream::traits_type::eof()) bytes << stream.rdbuf();
  if (!stream.is_open() || stream.bad() || bytes.bad())
    return Fail(ErrorCode::kIo, "{}: cannot be read ({})", path.string(), std::generic_category().message(errno));
  return std::move(bytes).str();
}

std::string Sha256Hex(const std::string& bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  Ensure(EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr) == 1,
         "SHA-256 is part of every OpenSSL");
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) hex += fmt::format("{:02x}", digest[i]);
  return hex;
}

Result<void> CheckSha256(const std::string& actual, const std::string& recorded, const std::string& file) {
  constexpr std::size_t kShown = 12;  // digits: enough to tell two files apart
  if (actual == recorded) return {};
  return Fail(ErrorCode::kBadInput, "{}: its SHA-256 is {}..., the recording lists {}...: the file was changed", file,
              actual.substr(0, kShown), recorded.substr(0, kShown));
}

}  // namespace rigcal
