#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "daemon/api/api.h"

namespace rigcal {

struct HttpLimits {
  std::size_t max_body_bytes = 64u << 10;  ///< the longest request is a list of stops
  int num_threads = 96;                    ///< one for each connection: 64 event streams and 32 that ask
  int read_timeout_s = 5;                  ///< without a byte
  int write_timeout_s = 5;                 ///< that a client takes nothing
  int keep_alive_s = 2;                    ///< between two requests of a connection
  int max_requests = 1000;                 ///< of a connection
};

/// A network address to listen on; the socket needs none of this.
struct TcpListen {
  std::string address;                     ///< HOST:PORT; port 0: one that is free
  std::filesystem::path token;             ///< file with the bearer token that every request but /healthz must carry
  std::filesystem::path certificate, key;  ///< of TLS, PEM
};

inline constexpr std::size_t kLeastTokenCharacters = 16;  ///< fewer can be guessed

/// Carries requests to the API, by HTTP. Its threads end when it does.
class HttpServer {
 public:
  /// Listens on a unix socket that its owner and the group rigcal (where there is one) may use, mode 0660. What a
  /// program that died has left there is replaced. `api` outlives it. Errors: kConflict: another program answers there;
  /// kBadInput: the path is too long for a socket, or something else stands there; kIo.
  static Result<std::unique_ptr<HttpServer>> ListenOnSocket(Api& api, const std::filesystem::path& socket,
                                                            const HttpLimits& limits = {});
  /// Listens on a network address, by TLS, for whoever knows the token. Errors: kBadInput: the address is none, or the
  /// token too short; those of ReadFile; kIo: certificate, key or address cannot be used.
  static Result<std::unique_ptr<HttpServer>> ListenOnTcp(Api& api, const TcpListen& listen,
                                                         const HttpLimits& limits = {});
  /// "/run/rigcal/rigcald.sock", "https://127.0.0.1:8443".
  [[nodiscard]] const std::string& Address() const;
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;
  /// Event streams must have ended, or end now (JobQueue::Close).
  ~HttpServer();

 private:
  struct Parts;
  explicit HttpServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// Group that may use the socket.
inline constexpr const char* kSocketGroup = "rigcal";

/// Where the service of this machine listens: $RIGCAL_SOCKET, else rigcald.sock in /run/rigcal where it is there, else
/// in DefaultRunFolder().
std::filesystem::path DefaultSocket();

}  // namespace rigcal
