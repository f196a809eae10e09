#include "tests/drivers/linuxcnc_real/linuxcnc_process.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>

#include "core/base/clock.h"
#include "core/base/descriptor.h"
#include "drivers/connect_to.h"

namespace rigcal {
namespace {

constexpr double kStart_s = 60, kAnswer_s = 10;  ///< against hangs
constexpr const char* kOrdinaryUser = "nobody";  ///< where this program is root, which LinuxCNC refuses to be
constexpr const char* kLock = "/tmp/linuxcnc.lock";

tl::unexpected<Error> CannotRun(const std::string& why) {
  return Fail(ErrorCode::kUnsupported, "LinuxCNC cannot run here: {}", why);
}

/// A port that was free a moment ago: linuxcncrsh cannot be told to take any.
int FreePort() {
  const Descriptor listener(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(own);
  bind(listener.Number(), reinterpret_cast<sockaddr*>(&own), length);
  getsockname(listener.Number(), reinterpret_cast<sockaddr*>(&own), &length);
  return ntohs(own.sin_port);
}

void BecomeOrdinary(const std::filesystem::path& folder) {
  setenv("HOME", folder.c_str(), 1);
  if (geteuid() != 0) return;
  const passwd* user = getpwnam(kOrdinaryUser);
  if (user == nullptr || setgroups(0, nullptr) != 0 || setgid(user->pw_gid) != 0 || setuid(user->pw_uid) != 0) _exit(1);
}

/// Runs a program in the folder; its output goes to a file there.
pid_t Run(const std::filesystem::path& folder, const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0) return child;
  setpgid(0, 0);
  BecomeOrdinary(folder);
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // it ends with the test, however that ends
  if (chdir(folder.c_str()) != 0) _exit(1);
  const int log = open("log", O_WRONLY | O_CREAT | O_APPEND, 0644), nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execvp(arguments[0], arguments.data());
  _exit(1);
}

std::string TextOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::filesystem::path MakeFolder(int port) {
  std::string name = std::filesystem::temp_directory_path() / "rigcal_linuxcnc_XXXXXX";
  const std::filesystem::path folder = mkdtemp(name.data());
  const std::filesystem::path from = RIGCAL_STUDIO_FOLDER;
  std::string ini = TextOf(from / "studio.ini");
  const std::string place = "DISPLAY = linuxcncrsh --port @PORT@";
  ini.replace(ini.find(place), place.size(), fmt::format("DISPLAY = linuxcncrsh --port {}", port));
  std::ofstream(folder / "studio.ini") << ini;
  std::ofstream(folder / "studio.tbl") << "T1 P1 Z0\n";
  std::filesystem::copy_file(from / "studio.hal", folder / "studio.hal");
  const passwd* user = getpwnam(kOrdinaryUser);
  if (geteuid() != 0 || user == nullptr) return folder;
  for (const auto& path : {folder, folder / "studio.ini", folder / "studio.tbl", folder / "studio.hal"}) {
    [[maybe_unused]] const int changed = chown(path.c_str(), user->pw_uid, user->pw_gid);
  }
  return folder;
}

}  // namespace

Result<std::unique_ptr<LinuxcncProcess>> LinuxcncProcess::Start() {
  if (std::system("command -v linuxcncrsh > /dev/null") != 0) return CannotRun("linuxcnc-uspace is not installed");
  if (std::filesystem::exists(kLock)) return CannotRun(fmt::format("another one runs already ({})", kLock));
  const int port = FreePort();
  const std::filesystem::path folder = MakeFolder(port);
  const pid_t child = Run(folder, {"linuxcnc", "studio.ini"});
  auto process = std::unique_ptr<LinuxcncProcess>(new LinuxcncProcess(folder, port, child));
  SystemClock clock;
  for (const double end_s = clock.NowS() + kStart_s; clock.NowS() < end_s; clock.Wait(0.1, {})) {
    if (waitpid(child, nullptr, WNOHANG) == child) {
      process->process_ = -1;
      return CannotRun("it ended at once: " + TextOf(folder / "log"));
    }
    if (ConnectTo({"127.0.0.1", port}, 1, clock, {})) return process;
  }
  return Fail(ErrorCode::kTimeout, "LinuxCNC did not listen within {} s: {}", kStart_s, TextOf(folder / "log"));
}

LinuxcncProcess::~LinuxcncProcess() {
  if (process_ > 0) {
    (void)Say("shutdown");
    SystemClock clock;
    int ended = 0;
    for (const double end_s = clock.NowS() + kAnswer_s; ended == 0 && clock.NowS() < end_s; clock.Wait(0.1, {})) {
      ended = waitpid(process_, nullptr, WNOHANG);
    }
    if (ended == 0) {
      kill(-process_, SIGTERM);
      waitpid(process_, nullptr, 0);
    }
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void LinuxcncProcess::SetPin(const std::string& pin, bool on) const {
  waitpid(Run(folder_, {"halcmd", "setp", pin, on ? "TRUE" : "FALSE"}), nullptr, 0);
}

std::string LinuxcncProcess::Say(const std::string& line) const {
  SystemClock clock;
  Result<LineConnection> connection = ConnectTo({"127.0.0.1", port_}, kAnswer_s, clock, {});
  if (!connection) return connection.error().message;
  std::vector<std::string> requests = {"hello EMC test 1.0", "set echo off", "set verbose on"};
  if (!line.starts_with("get")) requests.emplace_back("set enable EMCTOO");
  requests.push_back(line);
  for (const std::string& request : requests) connection->Send(request);
  std::string begin;  // "SET MODE " or "MODE "
  for (const char c : line.substr(line.starts_with("get ") ? 4 : 0)) {
    if (c == ' ' && begin.find(' ') != std::string::npos) break;
    begin += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  const double end_s = clock.NowS() + kAnswer_s;
  while (clock.NowS() < end_s && !connection->Closed() && !connection->Lost()) {
    connection->Await(20);
    connection->Receive();
    while (std::optional<std::string> answer = connection->TakeLine()) {
      if (answer->starts_with(begin)) return *answer;
    }
  }
  return "no answer to " + line;
}

}  // namespace rigcal
