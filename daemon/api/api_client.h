#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>

#include "core/base/result.h"

namespace rigcal {

/// Asks the service, over its socket. Errors of all: kIo: no service answers; what the service itself answers.
class ApiClient {
 public:
  explicit ApiClient(std::filesystem::path socket) : socket_(std::move(socket)) {}

  Result<nlohmann::json> Get(const std::string& path);
  Result<nlohmann::json> Post(const std::string& path, const nlohmann::json& body);
  /// The messages of an event stream, until it ends, `listener` returns false or the token is set. Errors also:
  /// kCancelled; kIo: the service went away.
  Result<void> Follow(const std::string& path, const std::function<bool(const nlohmann::json&)>& listener,
                      const std::stop_token& stop);
  /// Whether anybody answers.
  bool IsThere();

 private:
  std::filesystem::path socket_;
};

}  // namespace rigcal
