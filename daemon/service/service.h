#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "daemon/api/api.h"
#include "daemon/api/http_server.h"
#include "daemon/jobs/job_queue.h"
#include "daemon/jobs/station.h"
#include "daemon/jobs/worker.h"
#include "daemon/rig_lock.h"

namespace rigcal {

struct ServiceOptions {
  std::filesystem::path rig_file, state, socket, run_folder;
  std::optional<TcpListen> tcp;  ///< beside the socket
  int num_threads = 0;           ///< of the stages; 0: one for each processor
};

/// The service of one rig: holds it, runs its jobs, answers requests, keeps what is published right.
class Service {
 public:
  /// Brings everything up; when this returns, requests are answered. Jobs that an earlier service left unfinished are
  /// interrupted, and what is published is mended. Errors: those of LoadStation, RigLock::Take, the store, the journal
  /// and HttpServer.
  static Result<std::unique_ptr<Service>> Start(const ServiceOptions& options);
  /// Stops the running job, devices at rest, and everything else.
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// Reads the rig file again, for the next job. Errors: those of LoadStation; then the old one stays.
  Result<void> Reload();
  /// Whether the worker is alive: a job that was asked to stop did so in time.
  bool IsHealthy();
  /// "job 7 (recalibrate) runs, 2 wait": for systemctl status.
  std::string StatusText();
  /// Where it answers.
  std::vector<std::string> Addresses();

 private:
  explicit Service(ServiceOptions options) : options_(std::move(options)) {}
  Result<void> BringUp();
  /// One service for a rig, and for a state folder.
  Result<void> TakeLocks();
  Result<void> OpenStores();
  Result<void> Listen();
  /// Makes the folder show what is in force. A failure is told; the service can do without.
  void MendPublished();
  std::shared_ptr<const Station> CurrentStation();
  Result<JobOutcome> RunJob(JobHandle& handle);

  ServiceOptions options_;
  SystemClock clock_;
  std::mutex station_mutex_;
  std::shared_ptr<const Station> station_;
  std::optional<RigLock> lock_, state_lock_;
  std::unique_ptr<CalibrationStore> job_store_, api_store_;  ///< the worker's, and the API's
  std::unique_ptr<JobJournal> journal_;
  std::optional<JobQueue> queue_;
  std::optional<Api> api_;
  std::vector<std::unique_ptr<HttpServer>> servers_;
  std::optional<Worker> worker_;
};

}  // namespace rigcal
