#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>
#include <string>

#include "core/base/result.h"

namespace rigcal {

/// A request to the service, whatever carried it.
struct ApiRequest {
  std::string method, path;                  ///< "POST", "/api/v1/jobs"
  std::map<std::string, std::string> query;  ///< "?count=5"
  std::string body;
};

/// Messages one after the other, each as a server-sent event.
struct EventStream {
  /// The next message; waits for it, no longer than a few seconds (then it is a comment that keeps the line open).
  /// Nothing: that was the last one.
  std::function<std::optional<std::string>()> next;
};

struct ApiReply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::optional<EventStream> events;  ///< instead of a body
};

inline constexpr int kStatusOk = 200, kStatusAccepted = 202, kStatusBadRequest = 400, kStatusUnauthorized = 401,
                     kStatusNotFound = 404, kStatusWrongMethod = 405, kStatusConflict = 409, kStatusTooLarge = 413,
                     kStatusInternal = 500, kStatusUnavailable = 503, kStatusDiskFull = 507;

/// {"error": {"code", "message"}} with the status that fits.
ApiReply ErrorReply(const Error& error);
/// The same where HTTP itself was at fault.
ApiReply ErrorReply(int status, const std::string& code, const std::string& message);

/// The JSON text of a reply; text that is not UTF-8 (a file's name) is shown as far as it can be.
std::string ReplyText(const nlohmann::ordered_json& json);

/// "bad_input": as in a reply.
const char* NameOf(ErrorCode code);
/// Back; kIo for another word.
ErrorCode ErrorCodeFromName(const std::string& name);

}  // namespace rigcal
