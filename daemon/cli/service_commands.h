#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.h"
#include "daemon/api/api_client.h"
#include "daemon/cli/command.h"

namespace rigcal {

/// How a command that asks the service reaches it.
struct ServiceChoice {
  std::filesystem::path socket;  ///< of the service
  bool json = false;
};

/// Declares --socket and --json.
void AddServiceOptions(CLI::App& command, ServiceChoice& choice);

/// Prints an error as FailWith does. Status 2 where the request was at fault, 1 where the service was, or is not there.
int ServiceFailWith(const char* command, const Error& error);

/// Asks for a job; with `wait`, shows its progress until it has ended and gives its exit status.
int AskForJob(const char* command, const std::string& kind, const nlohmann::json& request, bool wait,
              const ServiceChoice& choice, const CommandSession& session);

/// Shows a job's progress until it has ended, and gives its exit status.
int FollowJob(const char* command, int id, const ServiceChoice& choice, const CommandSession& session);

}  // namespace rigcal
