#pragma once

#include "daemon/cli/command.h"

namespace rigcal {

/// The subcommands of `rigcal sim`.
void AddSimRenderCommand(CLI::App& sim, CommandSession& session);
void AddSimDisturbCommand(CLI::App& sim, CommandSession& session);
void AddSimJudgePatchesCommand(CLI::App& sim, CommandSession& session);
void AddSimServeCommand(CLI::App& sim, CommandSession& session);

}  // namespace rigcal
