#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/calibration_store.h"
#include "core/base/clock.h"
#include "daemon/api/api_reply.h"
#include "daemon/jobs/job_queue.h"
#include "daemon/jobs/station.h"

namespace rigcal {

/// What the requests are about. All of it outlives the API.
struct ApiWorld {
  JobQueue& queue;
  CalibrationStore& store;  ///< the API's own, which no other thread uses
  Clock& clock;
  std::function<std::shared_ptr<const Station>()> station;  ///< as it is now
  std::function<std::string()> now_text;                    ///< UTC, ISO 8601
};

struct ApiLimits {
  int max_event_streams = 64;  ///< each holds a thread and a connection
  double event_wait_s = 10;    ///< after which a comment shows that the line is open
  int max_listed_jobs = 500;
  std::size_t max_name = 128;     ///< characters of who asks
  std::size_t max_reason = 2000;  ///< characters of a reason
};

/// One thing that can be asked of the service: docs/openapi.json has the same.
struct ApiRoute {
  std::string_view method;
  std::string_view path;  ///< "/api/v1/jobs/{id}"
};

/// Answers requests, without a network: HttpServer carries them. Any thread may ask.
class Api {
 public:
  explicit Api(ApiWorld world, ApiLimits limits = {}) : world_(std::move(world)), limits_(limits) {}

  /// Every request gets a reply; a bug is told as one, and the service lives.
  ApiReply Answer(const ApiRequest& request);

  /// Counts an ended job, for the metrics.
  void CountEnded(const Job& job);

  /// All routes, in the order in which they are looked at.
  static std::vector<ApiRoute> Routes();

 private:
  struct Row;
  static std::span<const Row> Rows();
  using Parts = std::vector<std::string>;  ///< what stood for {...} in the path

  ApiReply Health(const ApiRequest& request, const Parts& parts);
  ApiReply Status(const ApiRequest& request, const Parts& parts);
  ApiReply Metrics(const ApiRequest& request, const Parts& parts);
  ApiReply ListJobs(const ApiRequest& request, const Parts& parts);
  ApiReply ShowJob(const ApiRequest& request, const Parts& parts);
  ApiReply SubmitJob(const ApiRequest& request, const Parts& parts);
  ApiReply CancelJob(const ApiRequest& request, const Parts& parts);
  ApiReply JobEvents(const ApiRequest& request, const Parts& parts);
  ApiReply ListCalibrations(const ApiRequest& request, const Parts& parts);
  ApiReply ShowCalibration(const ApiRequest& request, const Parts& parts);
  ApiReply DiffCalibrations(const ApiRequest& request, const Parts& parts);
  ApiReply Publish(const ApiRequest& request, const Parts& parts);
  ApiReply Rollback(const ApiRequest& request, const Parts& parts);

  Result<PublishRequest> ReadPublish(const ApiRequest& request, PublishKind kind, const std::optional<int>& revision);
  ApiReply MovePointer(const PublishRequest& wish);

  ApiWorld world_;
  ApiLimits limits_;
  std::mutex store_mutex_;
  std::mutex ended_mutex_;
  std::map<std::pair<std::string, std::string>, int> num_ended_;  ///< of each kind and state
  std::atomic<int> num_streams_ = 0;
};

}  // namespace rigcal
