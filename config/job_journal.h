#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/job.h"
#include "core/base/result.h"

namespace rigcal {

/// What the service was asked for and what became of it. Every change is on the disk when a call returns, so that a
/// job that began is known after a crash. An object belongs to one thread at a time. Errors of all: kIo, kDiskFull,
/// kTimeout, naming the journal.
class JobJournal {
 public:
  JobJournal() = default;
  JobJournal(const JobJournal&) = delete;
  JobJournal& operator=(const JobJournal&) = delete;
  virtual ~JobJournal() = default;

  /// Keeps a new job and gives its id; job.id is not looked at.
  virtual Result<int> Append(const Job& job) = 0;
  /// Replaces what is known of a job but for kind, request and who asked. Errors also: kNotFound.
  virtual Result<void> Update(const Job& job) = 0;
  /// Errors also: kNotFound.
  virtual Result<Job> Load(int id) = 0;
  /// The newest jobs, newest first, at most `count`.
  virtual Result<std::vector<Job>> Newest(int count) = 0;
  /// Jobs that wait or run are those of a service that ended: all become interrupted. Gives them, oldest first.
  virtual Result<std::vector<Job>> InterruptUnfinished(const std::string& now) = 0;
};

}  // namespace rigcal
