#include "daemon/service/service.h"

#include <chrono>
#include <utility>

#include "config/store/sqlite_journal.h"
#include "config/store/sqlite_store.h"
#include "config/utc_text.h"
#include "daemon/jobs/job_kinds.h"
#include "daemon/service/log.h"

namespace rigcal {
namespace {

/// A job that was asked to stop must do so within two seconds (issue 5); one that has not after this hangs, in a
/// driver's library or on a disk. Chosen long, because a restart costs more than waiting.
constexpr double kHangsAfterS = 60;

/// How many jobs keep their folder: the store has what counts, a folder some tens of megabytes of patches.
constexpr int kKeptJobFolders = 50;

std::string NowText() {
  return UtcText(std::chrono::system_clock::now());
}

LogPriority PriorityOf(const Job& job) {
  if (job.state == JobState::kCancelled || job.state == JobState::kInterrupted) return LogPriority::kWarning;
  if (job.state == JobState::kFailed || job.outcome.exit_status == kJobFailed) return LogPriority::kError;
  return job.outcome.exit_status == kJobAccepted ? LogPriority::kNotice : LogPriority::kWarning;
}

/// Each job's end, once: what it was, and what came of it.
void LogEnd(const Job& job) {
  Log(PriorityOf(job), fmt::format("job {} ({}) is {}: {}", job.id, job.kind, NameOf(job.state), job.outcome.message));
}

}  // namespace

Result<std::unique_ptr<Service>> Service::Start(const ServiceOptions& options) {
  std::unique_ptr<Service> service(new Service(options));
  if (auto up = service->BringUp(); !up) return Fail(up.error());
  return service;
}

Result<void> Service::OpenStores() {
  const std::filesystem::path file = station_->StoreFile();
  for (auto* store : {&job_store_, &api_store_}) {
    auto opened = OpenSqliteStore(file, {.create = true});
    if (!opened) return Fail(opened.error());
    *store = std::move(*opened);
  }
  auto journal = OpenSqliteJournal(station_->state / kJournalFile);
  if (!journal) return Fail(journal.error());
  journal_ = std::move(*journal);
  const auto interrupted = journal_->InterruptUnfinished(NowText());
  if (!interrupted) return Fail(interrupted.error());
  for (const Job& job : *interrupted) LogEnd(job);
  return {};
}

Result<void> Service::TakeLocks() {
  const RigHolder holder{.what = "rigcald", .ask_instead = "rigcal capture --what object"};
  Result<RigLock> lock = RigLock::Take(options_.run_folder, options_.rig_file, holder);
  if (!lock) return Fail(lock.error());
  lock_.emplace(std::move(*lock));
  Result<RigLock> state_lock = RigLock::Take(station_->state, station_->state, holder);
  if (!state_lock) return Fail(state_lock.error());
  state_lock_.emplace(std::move(*state_lock));
  return {};
}

Result<void> Service::Listen() {
  auto server = HttpServer::ListenOnSocket(*api_, options_.socket);
  if (!server) return Fail(server.error());
  servers_.push_back(std::move(*server));
  if (!options_.tcp) return {};
  server = HttpServer::ListenOnTcp(*api_, *options_.tcp);
  if (!server) return Fail(server.error());
  servers_.push_back(std::move(*server));
  return {};
}

std::vector<std::string> Service::Addresses() {
  std::vector<std::string> addresses;
  for (const auto& server : servers_) addresses.push_back(server->Address());
  return addresses;
}

Result<void> Service::BringUp() {
  Result<Station> station = LoadStation(options_.rig_file, options_.state, NumThreads(options_.num_threads));
  if (!station) return Fail(station.error());
  station_ = std::make_shared<const Station>(std::move(*station));
  if (auto locked = TakeLocks(); !locked) return locked;
  if (auto opened = OpenStores(); !opened) return opened;
  MendPublished();
  JobQueueOptions queue;
  queue.journal_failed = [](const Error& error) { Log(LogPriority::kError, error.message); };
  queue_.emplace(*journal_, clock_, NowText, std::move(queue));
  api_.emplace(ApiWorld{*queue_, *api_store_, clock_, [this] { return CurrentStation(); }, NowText});
  if (auto listening = Listen(); !listening) return listening;
  const auto ended = [this](const Job& job) {
    LogEnd(job);
    api_->CountEnded(job);
  };
  worker_.emplace(
      *queue_, clock_, [this](JobHandle& handle) { return RunJob(handle); }, ended);
  return {};
}

Service::~Service() {
  worker_.reset();  // closes the queue: event streams end
  servers_.clear();
}

void Service::MendPublished() {
  const auto station = CurrentStation();
  const auto mended = RepairPublished(*job_store_, station->name, station->publish, clock_, {});
  if (!mended) Log(LogPriority::kError, mended.error().message);
  if (mended && *mended) {
    Log(LogPriority::kNotice, fmt::format("{}: now shows what is in force", station->publish.folder.string()));
  }
}

std::shared_ptr<const Station> Service::CurrentStation() {
  const std::lock_guard lock(station_mutex_);
  return station_;
}

Result<void> Service::Reload() {
  Result<Station> station = LoadStation(options_.rig_file, options_.state, NumThreads(options_.num_threads));
  if (!station) return Fail(station.error());
  const std::lock_guard lock(station_mutex_);
  station_ = std::make_shared<const Station>(std::move(*station));
  return {};
}

bool Service::IsHealthy() {
  return queue_->StoppingForS().value_or(0) < kHangsAfterS;
}

std::string Service::StatusText() {
  const auto running = queue_->Running();
  const std::string waiting = fmt::format("{} wait", queue_->NumWaiting());
  if (!running) return fmt::format("no job runs, {}", waiting);
  return fmt::format("job {} ({}) runs, {}", running->job.id, running->job.kind, waiting);
}

Result<JobOutcome> Service::RunJob(JobHandle& handle) {
  const Job& job = handle.Content();
  const std::shared_ptr<const Station> station = CurrentStation();
  const JobKind* kind = FindJobKind(job.kind);
  if (kind == nullptr) return Fail(ErrorCode::kUnsupported, "'{}' is no kind of job", job.kind);
  Log(LogPriority::kInformation, fmt::format("job {} ({}) begins, for {}", job.id, job.kind, job.by));
  std::error_code ignored;  // what is left over is only untidy
  std::filesystem::remove_all(station->JobFolder(job.id - kKeptJobFolders), ignored);
  const nlohmann::json request = nlohmann::json::parse(job.request);
  JobWork work{.request = request,
               .station = *station,
               .store = *job_store_,
               .clock = clock_,
               .handle = handle,
               .now_text = NowText,
               .tell = [&job](const std::string& sentence) {
                 Log(LogPriority::kInformation, fmt::format("job {} ({}): {}", job.id, job.kind, sentence));
               }};
  return kind->run(work);
}

}  // namespace rigcal
