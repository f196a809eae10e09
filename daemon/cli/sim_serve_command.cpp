#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <sstream>

#include "daemon/cli/command.h"
#include "daemon/cli/served_studio.h"
#include "daemon/cli/sim_commands.h"

namespace rigcal {
namespace {

constexpr int kSlice_ms = 100;  ///< between two looks at the stop token
constexpr double kGiga = 1e9;

struct ServeArguments {
  std::string recording;
  ServedNetwork network;
  double gigabits_per_second = 0;
  bool no_resend = false;
  std::string motion = "grbl";
};

/// "kill cam1" and "revive cam1": the power of a camera. Other lines are answered with what there is.
void Obey(const std::string& line, const ServedStudio& studio) {
  std::istringstream words(line);
  std::string what, id;
  words >> what >> id;
  for (std::size_t c = 0; c < studio.Cameras().size(); ++c) {
    if (studio.IdOf(c) != id) continue;
    sim::GigeDevice& camera = *studio.Cameras()[c];
    if (what == "kill") camera.Kill();
    const Result<void> done = what == "revive" ? camera.Revive() : Result<void>();
    if (what != "kill" && what != "revive") break;
    fmt::print("{}\n", done ? what + " " + id : done.error().message);
    std::fflush(stdout);
    return;
  }
  fmt::print("'{}' is none of: kill CAMERA, revive CAMERA\n", line);
  std::fflush(stdout);
}

/// Serves until the stop token is set; lines of the standard input are obeyed.
void ServeUntil(const std::stop_token& stop, const ServedStudio& studio) {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  std::string received;
  while (!stop.stop_requested()) {
    if (poll(&input, 1, kSlice_ms) <= 0) continue;
    std::array<char, 256> bytes{};
    const ssize_t count = read(STDIN_FILENO, bytes.data(), bytes.size());
    if (count <= 0) input.fd = -1;  // nobody tells it anything any more
    received.append(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    for (std::size_t end = received.find('\n'); end != std::string::npos; end = received.find('\n')) {
      Obey(received.substr(0, end), studio);
      received.erase(0, end + 1);
    }
  }
}

Result<void> Serve(ServeArguments& arguments, const CommandSession& session) {
  SystemClock clock;
  arguments.network.can_resend = !arguments.no_resend;
  arguments.network.bits_per_second = arguments.gigabits_per_second * kGiga;
  const auto studio =
      ServedStudio::Start(arguments.recording, arguments.network,
                          arguments.motion == "grbl" ? ServedMotion::kGrbl : ServedMotion::kLinuxcnc, clock);
  if (!studio) return Fail(studio.error());
  for (std::size_t c = 0; c < (*studio)->Cameras().size(); ++c) {
    const sim::GigeDevice& camera = *(*studio)->Cameras()[c];
    fmt::print("camera {}: GigE Vision at {}, serial {}\n", (*studio)->IdOf(c), camera.Address(), camera.Serial());
  }
  fmt::print("table: {}\n", (*studio)->TableText());
  std::fflush(stdout);
  ServeUntil(session.stop, **studio);
  for (std::size_t c = 0; c < (*studio)->Cameras().size(); ++c) {
    const sim::GigeCounts counts = (*studio)->Cameras()[c]->Counts();
    fmt::print("camera {}: {} shots, {} pictures sent, {} packets lost, {} sent again\n", (*studio)->IdOf(c),
               counts.shots, counts.frames, counts.lost, counts.resent);
  }
  return {};
}

}  // namespace

void AddSimServeCommand(CLI::App& sim, CommandSession& session) {
  CLI::App* command = sim.add_subcommand(
      "serve", "A recording of a turntable behind real protocols, until SIGINT: GigE Vision cameras and a table");
  const auto arguments = std::make_shared<ServeArguments>();
  command->add_option("--recording", arguments->recording, "Folder of `rigcal sim render --recording`")->required();
  command->add_option("--motion", arguments->motion, "What moves the table")
      ->check(CLI::IsMember({"grbl", "linuxcnc"}))
      ->capture_default_str();
  command->add_option("--loss", arguments->network.loss, "Share of the pictures' packets that are lost")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_flag("--no-resend", arguments->no_resend, "The cameras do not send packets again");
  command->add_option("--gigabits-per-s", arguments->gigabits_per_second, "Of each camera; 0: as quickly as it can")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command->add_option("--random-seed", arguments->network.random_seed, "Of the packets that are lost")
      ->capture_default_str();
  command->callback([arguments, &session] {
    const Result<void> served = Serve(*arguments, session);
    session.exit_status = served ? kExitAccepted : FailWith("sim serve", served.error());
  });
}

}  // namespace rigcal
