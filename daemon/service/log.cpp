#include "daemon/service/log.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace rigcal {
namespace {

/// systemd says in JOURNAL_STREAM which device and inode leads to the journal.
bool StderrIsJournal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || fstat(STDERR_FILENO, &status) != 0) return false;
  return stream == fmt::format("{}:{}", status.st_dev, status.st_ino);
}

}  // namespace

void Log(LogPriority priority, const std::string& sentence) {
  static const bool to_journal = StderrIsJournal();
  std::string line = to_journal ? fmt::format("<{}>{}", static_cast<int>(priority), sentence) : "rigcald: " + sentence;
  std::ranges::replace(line, '\n', ' ');
  line += '\n';
  // One write for a line. Nothing can be done where not even a log can be written.
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace rigcal
