#include "daemon/api/http_server.h"

#include <grp.h>
#include <httplib.h>
#include <openssl/crypto.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <thread>

#include "config/read_file.h"
#include "core/base/descriptor.h"
#include "core/base/socket_address.h"
#include "daemon/rig_lock.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAnything = ".*";
constexpr int kNoPort = 1;  // the library wants one, a unix socket has none

ApiRequest RequestOf(const httplib::Request& request) {
  ApiRequest asked{.method = request.method, .path = request.path, .query = {}, .body = request.body};
  for (const auto& [key, value] : request.params) asked.query.emplace(key, value);
  return asked;
}

void Send(ApiReply reply, httplib::Response& response) {
  response.status = reply.status;
  if (!reply.events) {
    response.set_content(reply.body, reply.type);
    return;
  }
  response.set_header("Cache-Control", "no-store");
  response.set_chunked_content_provider(reply.type,
                                        [events = std::move(*reply.events)](std::size_t, httplib::DataSink& sink) {
                                          const std::optional<std::string> text = events.next();
                                          if (!text) {
                                            sink.done();
                                            return true;
                                          }
                                          return sink.write(text->data(), text->size());
                                        });
}

/// What the library refuses by itself gets a body like everything else.
void ExplainRefusal(const httplib::Request& request, httplib::Response& response) {
  if (!response.body.empty()) return;
  const bool large = response.status == kStatusTooLarge;
  Send(ErrorReply(response.status, large ? "too_large" : "bad_request",
                  large ? "the body is too large" : "the request cannot be understood: " + request.path),
       response);
}

Result<sockaddr_un> AddressOf(const fs::path& socket) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = socket.string();
  if (path.size() >= sizeof(address.sun_path)) {
    return Fail(ErrorCode::kBadInput, "{}: is too long for a socket, {} characters of at most {}", path, path.size(),
                sizeof(address.sun_path) - 1);
  }
  path.copy(address.sun_path, path.size());
  return address;
}

/// Makes room for the socket: nobody answers there any more.
Result<void> RemoveLeftOver(const fs::path& socket) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(socket, error))) return {};
  if (!fs::is_socket(socket, error)) {
    return Fail(ErrorCode::kBadInput, "{}: is no socket, and is kept", socket.string());
  }
  const Result<sockaddr_un> address = AddressOf(socket);
  if (!address) return Fail(address.error());
  const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (connect(probe.Number(), reinterpret_cast<const sockaddr*>(&*address), sizeof(*address)) == 0) {
    return Fail(ErrorCode::kConflict, "{}: another program answers there", socket.string());
  }
  fs::remove(socket, error);
  return {};
}

/// Owner and group may connect; the group stays the program's own where there is none of the name.
Result<void> OpenToGroup(const fs::path& socket) {
  if (const group* wanted = getgrnam(kSocketGroup); wanted != nullptr) {
    constexpr auto kOwnerStays = static_cast<uid_t>(-1);
    if (chown(socket.c_str(), kOwnerStays, wanted->gr_gid) != 0 && errno != EPERM) {
      return Fail(ErrorCode::kIo, "{}: cannot be given to the group {} ({})", socket.string(), kSocketGroup,
                  std::generic_category().message(errno));
    }
  }
  constexpr mode_t kOwnerAndGroup = 0660;
  if (chmod(socket.c_str(), kOwnerAndGroup) == 0) return {};
  return Fail(ErrorCode::kIo, "{}: its mode cannot be set ({})", socket.string(),
              std::generic_category().message(errno));
}

Result<std::string> TokenIn(const fs::path& file) {
  Result<std::string> token = ReadFile(file);
  if (!token) return token;
  while (!token->empty() && std::isspace(static_cast<unsigned char>(token->back())) != 0) token->pop_back();
  if (token->size() >= kLeastTokenCharacters) return token;
  return Fail(ErrorCode::kBadInput, "{}: the token has {} characters, at least {} are needed", file.string(),
              token->size(), kLeastTokenCharacters);
}

}  // namespace

struct HttpServer::Parts {
  explicit Parts(std::unique_ptr<httplib::Server> of) : server(std::move(of)) {}

  std::string address;
  fs::path socket;  ///< removed at the end; empty: there is none
  std::unique_ptr<httplib::Server> server;
  std::jthread listener;

  void Configure(Api& api, const HttpLimits& limits) {
    const auto answer = [&api](const httplib::Request& request, httplib::Response& response) {
      Send(api.Answer(RequestOf(request)), response);
    };
    server->Get(kAnything, answer).Post(kAnything, answer).Put(kAnything, answer).Patch(kAnything, answer);
    server->Delete(kAnything, answer).Options(kAnything, answer);
    server->set_error_handler(ExplainRefusal);
    server->set_payload_max_length(limits.max_body_bytes);
    server->set_read_timeout(limits.read_timeout_s).set_write_timeout(limits.write_timeout_s);
    server->set_keep_alive_timeout(limits.keep_alive_s);
    server->set_keep_alive_max_count(static_cast<std::size_t>(limits.max_requests));
    server->new_task_queue = [num = limits.num_threads] {
      return new httplib::ThreadPool(static_cast<std::size_t>(num));  // the library deletes it
    };
  }

  /// Only who knows the token is answered, but for the question whether anybody is there.
  void AskForToken(const std::string& token) {
    server->set_pre_routing_handler([wanted = "Bearer " + token](const httplib::Request& request,
                                                                 httplib::Response& response) {
      const std::string given = request.get_header_value("Authorization");
      const bool knows =
          given.size() == wanted.size() && CRYPTO_memcmp(given.data(), wanted.data(), wanted.size()) == 0;
      if (knows || request.path == "/healthz") return httplib::Server::HandlerResponse::Unhandled;
      Send(ErrorReply(kStatusUnauthorized, "unauthorized", "the request carries no token, or a wrong one"), response);
      return httplib::Server::HandlerResponse::Handled;
    });
  }

  /// Its stop works only once it runs.
  bool Start() {
    listener = std::jthread([this] { server->listen_after_bind(); });
    constexpr int kPolls = 10'000;
    for (int i = 0; i < kPolls && !server->is_running(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return server->is_running();
  }
};

HttpServer::HttpServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

HttpServer::~HttpServer() {
  parts_->server->stop();
  parts_->listener.join();
  std::error_code ignored;
  if (!parts_->socket.empty()) fs::remove(parts_->socket, ignored);
}

const std::string& HttpServer::Address() const {
  return parts_->address;
}

Result<std::unique_ptr<HttpServer>> HttpServer::ListenOnSocket(Api& api, const fs::path& socket,
                                                               const HttpLimits& limits) {
  if (const auto address = AddressOf(socket); !address) return Fail(address.error());
  std::error_code error;
  fs::create_directories(fs::absolute(socket).parent_path(), error);
  if (auto removed = RemoveLeftOver(socket); !removed) return Fail(removed.error());
  auto parts = std::make_unique<Parts>(std::make_unique<httplib::Server>());
  parts->socket = socket;
  parts->address = socket.string();
  parts->server->set_address_family(AF_UNIX);
  parts->Configure(api, limits);
  constexpr mode_t kNobodyElse = 0177;
  const mode_t before = umask(kNobodyElse);  // until the group is right
  errno = 0;
  const bool bound = parts->server->bind_to_port(socket.string(), kNoPort);
  const int failure = errno;
  umask(before);
  if (!bound) {
    return Fail(ErrorCode::kIo, "{}: nothing can listen there ({})", socket.string(),
                std::generic_category().message(failure));
  }
  if (auto opened = OpenToGroup(socket); !opened) return Fail(opened.error());
  if (!parts->Start()) return Fail(ErrorCode::kTimeout, "{}: the server does not start", socket.string());
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(parts)));
}

Result<std::unique_ptr<HttpServer>> HttpServer::ListenOnTcp(Api& api, const TcpListen& listen,
                                                            const HttpLimits& limits) {
  const auto address = ParseSocketAddress(listen.address, kAnyPort);
  if (!address) return Fail(ErrorCode::kBadInput, "'{}' is no address, HOST:PORT is needed", listen.address);
  const Result<std::string> token = TokenIn(listen.token);
  if (!token) return Fail(token.error());
  auto parts =
      std::make_unique<Parts>(std::make_unique<httplib::SSLServer>(listen.certificate.c_str(), listen.key.c_str()));
  if (!parts->server->is_valid()) {
    return Fail(ErrorCode::kIo, "{}, {}: cannot be used as certificate and key of TLS", listen.certificate.string(),
                listen.key.string());
  }
  parts->Configure(api, limits);
  parts->AskForToken(*token);
  int port = address->port;
  const bool bound = port == kAnyPort ? (port = parts->server->bind_to_any_port(address->host)) > 0
                                      : parts->server->bind_to_port(address->host, port);
  if (!bound) return Fail(ErrorCode::kIo, "{}: nothing can listen there", listen.address);
  parts->address = "https://" + ToText({address->host, port});
  if (!parts->Start()) return Fail(ErrorCode::kTimeout, "{}: the server does not start", listen.address);
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(parts)));
}

fs::path DefaultSocket() {
  if (const char* socket = std::getenv("RIGCAL_SOCKET"); socket != nullptr && *socket != '\0') return socket;
  constexpr const char* kName = "rigcald.sock";
  const fs::path system = fs::path("/run/rigcal") / kName;
  std::error_code error;
  return fs::exists(system, error) ? system : DefaultRunFolder() / kName;
}

}  // namespace rigcal
