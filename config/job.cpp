#include "config/job.h"

#include <array>
#include <utility>

namespace rigcal {
namespace {

constexpr std::array<std::pair<JobState, const char*>, 6> kStates = {{{JobState::kQueued, "queued"},
                                                                      {JobState::kRunning, "running"},
                                                                      {JobState::kDone, "done"},
                                                                      {JobState::kFailed, "failed"},
                                                                      {JobState::kCancelled, "cancelled"},
                                                                      {JobState::kInterrupted, "interrupted"}}};

}  // namespace

const char* NameOf(JobState state) {
  for (const auto& [known, name] : kStates) {
    if (known == state) return name;
  }
  return "";
}

std::optional<JobState> JobStateFromName(std::string_view name) {
  for (const auto& [state, known] : kStates) {
    if (known == name) return state;
  }
  return std::nullopt;
}

bool HasEnded(JobState state) {
  return state != JobState::kQueued && state != JobState::kRunning;
}

}  // namespace rigcal
