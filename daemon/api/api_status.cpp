#include "config/provenance.h"
#include "daemon/api/api.h"
#include "daemon/api/job_json.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kLastJobs = 5;

Json EventJson(const std::optional<PublishEvent>& event) {
  if (!event) return nullptr;
  return {{"revision", event->revision}, {"published_at", event->time}, {"by", event->by}, {"reason", event->reason}};
}

Json RigJson(const Station& station) {
  Json cameras = Json::array();
  for (const CameraSettings& camera : station.rig.cameras) {
    cameras.push_back({{"id", camera.id}, {"driver", camera.driver}});
  }
  const std::string& driver = station.rig.positioner.driver;
  return {{"name", station.name},
          {"file", station.rig_file.string()},
          {"positioner_driver", driver.empty() ? Json(nullptr) : Json(driver)},
          {"cameras", std::move(cameras)},
          {"state", station.state.string()},
          {"published_in", station.publish.folder.string()}};
}

std::string Gauge(const char* name, const char* help, int value) {
  return fmt::format("# HELP {} {}\n# TYPE {} gauge\n{} {}\n", name, help, name, name, value);
}

}  // namespace

ApiReply Api::Health(const ApiRequest& /*request*/, const Parts& /*parts*/) {
  return {.body = ReplyText({{"status", "ok"}}), .events = {}};
}

ApiReply Api::Status(const ApiRequest& /*request*/, const Parts& /*parts*/) {
  const std::shared_ptr<const Station> station = world_.station();
  const auto in_force = [&] {
    const std::lock_guard lock(store_mutex_);
    return world_.store.InForce(station->name);
  }();
  if (!in_force) return ErrorReply(in_force.error());
  const auto jobs = world_.queue.Newest(kLastJobs);
  if (!jobs) return ErrorReply(jobs.error());
  Json last = Json::array();
  for (const JobStatus& status : *jobs) last.push_back(JobJson(status));
  const auto running = world_.queue.Running();
  return {.body = ReplyText({{"version", std::string(ProgramVersion())},
                             {"time", world_.now_text()},
                             {"rig", RigJson(*station)},
                             {"in_force", EventJson(*in_force)},
                             {"running", running ? JobJson(*running) : Json(nullptr)},
                             {"num_waiting", world_.queue.NumWaiting()},
                             {"last_jobs", std::move(last)}}),
          .events = {}};
}

ApiReply Api::Metrics(const ApiRequest& /*request*/, const Parts& /*parts*/) {
  const auto in_force = [&] {
    const std::lock_guard lock(store_mutex_);
    return world_.store.InForce(world_.station()->name);
  }();
  const int revision = in_force && *in_force ? (*in_force)->revision : 0;
  std::string text = fmt::format(
      "# HELP rigcal_build_info The program.\n# TYPE rigcal_build_info gauge\nrigcal_build_info{{version=\"{}\"}} 1\n",
      ProgramVersion());
  text += Gauge("rigcal_jobs_waiting", "Jobs in the queue.", static_cast<int>(world_.queue.NumWaiting()));
  text += Gauge("rigcal_job_running", "1 while a job runs.", world_.queue.Running() ? 1 : 0);
  text += Gauge("rigcal_event_streams", "Clients that follow a job.", num_streams_);
  text += Gauge("rigcal_revision_in_force", "Number of the calibration in force, 0 without one.", revision);
  text += "# HELP rigcal_jobs_ended_total Jobs that ended since the service started.\n";
  text += "# TYPE rigcal_jobs_ended_total counter\n";
  const std::lock_guard lock(ended_mutex_);
  for (const auto& [key, count] : num_ended_) {
    text += fmt::format("rigcal_jobs_ended_total{{kind=\"{}\",state=\"{}\"}} {}\n", key.first, key.second, count);
  }
  return {.type = "text/plain; version=0.0.4", .body = std::move(text), .events = {}};
}

}  // namespace rigcal
