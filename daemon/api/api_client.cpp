#include "daemon/api/api_client.h"

#include <httplib.h>

#include <optional>

#include "daemon/api/api_reply.h"

namespace rigcal {
namespace {

using Json = nlohmann::json;

constexpr int kNoPort = 1;           // a unix socket has none
constexpr int kAnswerWithin_s = 60;  // a publication may wait for another, a store for a slow disk
constexpr const char* kData = "data: ";

httplib::Client ClientFor(const std::filesystem::path& socket) {
  httplib::Client client(socket.string(), kNoPort);
  client.set_address_family(AF_UNIX);
  client.set_read_timeout(kAnswerWithin_s);
  client.set_write_timeout(kAnswerWithin_s);
  return client;
}

tl::unexpected<Error> NobodyAnswers(const std::filesystem::path& socket) {
  return Fail(ErrorCode::kIo, "no service answers at {}; `systemctl start rigcald` starts it", socket.string());
}

/// The Error in a reply's body.
tl::unexpected<Error> Refusal(int status, const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object() || !json.contains("error")) {
    return Fail(ErrorCode::kIo, "the service answers with status {}", status);
  }
  const Json& error = json["error"];
  return Fail(ErrorCodeFromName(error.value("code", "")), "{}", error.value("message", ""));
}

Result<Json> ContentOf(const std::filesystem::path& socket, const httplib::Result& result) {
  if (!result) return NobodyAnswers(socket);
  if (result->status >= kStatusBadRequest) return Refusal(result->status, result->body);
  Json json = Json::parse(result->body, nullptr, false);
  if (json.is_discarded()) return Fail(ErrorCode::kIo, "the service's answer is no JSON");
  return json;
}

}  // namespace

Result<Json> ApiClient::Get(const std::string& path) {
  return ContentOf(socket_, ClientFor(socket_).Get(path));
}

Result<Json> ApiClient::Post(const std::string& path, const Json& body) {
  return ContentOf(socket_, ClientFor(socket_).Post(path, body.dump(), "application/json"));
}

bool ApiClient::IsThere() {
  return Get("/healthz").has_value();
}

Result<void> ApiClient::Follow(const std::string& path, const std::function<bool(const Json&)>& listener,
                               const std::stop_token& stop) {
  httplib::Client client = ClientFor(socket_);
  std::string unread;
  int status = 0;
  bool go_on = true;
  const auto on_response = [&](const httplib::Response& response) {
    status = response.status;
    return true;
  };
  const auto on_bytes = [&](const char* bytes, std::size_t count) {
    unread.append(bytes, count);
    if (status >= kStatusBadRequest) return true;
    for (std::size_t end = unread.find('\n'); end != std::string::npos && go_on; end = unread.find('\n')) {
      const std::string line = unread.substr(0, end);
      unread.erase(0, end + 1);
      if (line.starts_with(kData)) go_on = listener(Json::parse(line.substr(std::string(kData).size())));
    }
    return go_on && !stop.stop_requested();
  };
  const std::stop_callback on_stop(stop, [&client] { client.stop(); });
  const httplib::Result result = client.Get(path, on_response, on_bytes);
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "following the job was stopped; the job goes on");
  if (status >= kStatusBadRequest) return Refusal(status, unread);
  if (status == 0) return NobodyAnswers(socket_);
  if (!result && go_on) return Fail(ErrorCode::kIo, "the service at {} went away", socket_.string());
  return {};
}

}  // namespace rigcal
