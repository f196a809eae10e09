#include "daemon/cli/store_options.h"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>

#include "config/store/sqlite_store.h"
#include "config/utc_text.h"
#include "core/base/joined.h"

namespace rigcal {

void AddStoreOptions(CLI::App& command, StoreChoice& choice) {
  command.add_option("--state", choice.state, "Folder with the calibration store")->capture_default_str();
  command.add_option("--rig", choice.rig, "Name of the rig; may be left out when the store has one only");
}

Result<RigStore> OpenRigStore(const StoreChoice& choice) {
  const std::filesystem::path file = choice.state / kStoreFile;
  auto store = OpenSqliteStore(file);
  if (!store) return Fail(store.error());
  const auto rigs = (*store)->Rigs();
  if (!rigs) return Fail(rigs.error());
  const std::string known = rigs->empty() ? "none" : Joined(*rigs, ", ");
  if (choice.rig.empty() && rigs->size() != 1) {
    return Fail(ErrorCode::kBadInput, "{}: has {} rigs ({}), --rig says which one is meant", file.string(),
                rigs->size(), known);
  }
  if (!choice.rig.empty() && std::ranges::find(*rigs, choice.rig) == rigs->end()) {
    return Fail(ErrorCode::kNotFound, "{}: has no rig '{}'; its rigs: {}", file.string(), choice.rig, known);
  }
  return RigStore{std::move(*store), choice.rig.empty() ? rigs->front() : choice.rig};
}

bool NamesFile(const std::string& argument) {
  std::error_code ignored;
  return argument.find('/') != std::string::npos || std::filesystem::exists(argument, ignored);
}

Result<int> RevisionNumber(const std::string& argument) {
  int number = 0;
  const char* end = argument.data() + argument.size();
  const auto parsed = std::from_chars(argument.data(), end, number);
  if (parsed.ec != std::errc() || parsed.ptr != end || number < 1) {
    return Fail(ErrorCode::kBadInput, "'{}' is no revision, a number from 1 is needed", argument);
  }
  return number;
}

Result<std::optional<int>> NumberInForce(RigStore& opened) {
  const auto event = opened.store->InForce(opened.rig);
  if (!event) return Fail(event.error());
  return *event ? std::optional((*event)->revision) : std::nullopt;
}

std::string UserName() {
  const passwd* user = getpwuid(geteuid());
  return user != nullptr ? user->pw_name : fmt::format("uid {}", geteuid());
}

std::string NowText() {
  return UtcText(std::chrono::system_clock::now());
}

}  // namespace rigcal
