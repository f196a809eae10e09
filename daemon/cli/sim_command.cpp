#include "daemon/cli/command.h"
#include "daemon/cli/sim_commands.h"

namespace rigcal {

void AddSimCommand(CLI::App& app, CommandSession& session) {
  CLI::App* sim = app.add_subcommand("sim", "The simulated studio");
  sim->require_subcommand(1);
  AddSimRenderCommand(*sim, session);
  AddSimDisturbCommand(*sim, session);
  AddSimJudgePatchesCommand(*sim, session);
  AddSimServeCommand(*sim, session);
}

}  // namespace rigcal
