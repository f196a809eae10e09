#include "daemon/cli/command.h"

namespace rigcal {

void AddSimCommand(CLI::App& app, CommandSession& /*session*/) {
  CLI::App* sim = app.add_subcommand("sim", "The simulated studio");
  sim->require_subcommand(1);
}

}  // namespace rigcal
