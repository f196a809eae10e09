#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/validate/validate.h"

namespace rigcal {

enum class JobState {
  kQueued,
  kRunning,
  kDone,  ///< it came to its end; a verdict may still be against the result
  kFailed,
  kCancelled,
  kInterrupted,  ///< the service ended while it waited or ran
};

/// "queued", "running", "done", "failed", "cancelled", "interrupted".
const char* NameOf(JobState state);
/// Nothing for a word that is none of a state.
std::optional<JobState> JobStateFromName(std::string_view name);
/// Whether nothing will happen to the job any more.
bool HasEnded(JobState state);

/// How a job ended, as the command line tells it (issue 5).
inline constexpr int kJobAccepted = 0, kJobFailed = 1, kJobNotAccepted = 3;

struct JobOutcome {
  std::optional<Verdict> verdict;  ///< of jobs that calibrate
  std::optional<int> revision;     ///< what was stored, whatever the verdict
  std::string message;             ///< one sentence
  int exit_status = kJobFailed;
};

/// One piece of work of the service, as its journal keeps it.
struct Job {
  int id = 0;           ///< given by the journal, rising
  std::string kind;     ///< "recalibrate"
  std::string request;  ///< JSON: what was asked for
  std::string by;       ///< who asked
  JobState state = JobState::kQueued;
  std::string queued_at, begun_at, ended_at;  ///< ISO 8601, UTC; empty: not yet
  std::string recording;                      ///< folder that it takes or reads; empty: none so far
  JobOutcome outcome;                         ///< once HasEnded(state)
};

}  // namespace rigcal
