#pragma once

#include <CLI/CLI.hpp>
#include <stop_token>

#include "core/base/result.h"

namespace rigcal {

/// Exit statuses of the command line.
inline constexpr int kExitAccepted = 0;
inline constexpr int kExitInternal = 1;
inline constexpr int kExitBadInput = 2;
inline constexpr int kExitNotAccepted = 3;

/// What every subcommand shares. Each Add...Command declares its options and, as callback, sets exit_status.
struct CommandSession {
  std::stop_token stop;  ///< set by SIGINT and SIGTERM
  bool on_terminal = false;
  int exit_status = kExitAccepted;
};

/// Prints an error as "rigcal COMMAND: sentence" and gives its exit status.
int FailWith(const char* command, const Error& error);

void AddRefineCommand(CLI::App& app, CommandSession& session);
void AddValidateCommand(CLI::App& app, CommandSession& session);
void AddMvsCommand(CLI::App& app, CommandSession& session);
void AddCompareCommand(CLI::App& app, CommandSession& session);
void AddExportCommand(CLI::App& app, CommandSession& session);
void AddRecordingCommand(CLI::App& app, CommandSession& session);
void AddRigCommand(CLI::App& app, CommandSession& session);
void AddCaptureCommand(CLI::App& app, CommandSession& session);
void AddDevicesCommand(CLI::App& app, CommandSession& session);
void AddSeedCommand(CLI::App& app, CommandSession& session);
void AddChartCommand(CLI::App& app, CommandSession& session);
void AddHistoryCommands(CLI::App& app, CommandSession& session);
void AddPublishCommands(CLI::App& app, CommandSession& session);
void AddDriftCommand(CLI::App& app, CommandSession& session);
void AddStoreCommand(CLI::App& app, CommandSession& session);
void AddServiceCommands(CLI::App& app, CommandSession& session);
void AddSimCommand(CLI::App& app, CommandSession& session);

}  // namespace rigcal
