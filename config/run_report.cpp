#include "config/run_report.h"

#include "config/atomic_file.h"
#include "config/json_text.h"
#include "config/rig_report.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

Json Numbers(const std::vector<double>& numbers) {
  Json json = Json::array();
  for (double number : numbers) json.push_back(NumberJson(number));
  return json;
}

Json ReasonsJson(const std::vector<Reason>& reasons) {
  Json json = Json::array();
  for (const Reason& reason : reasons) {
    Json entry = {{"check", reason.check},
                  {"value", NumberJson(reason.value)},
                  {"limit", NumberJson(reason.limit)},
                  {"unit", reason.unit}};
    if (reason.view) entry["view"] = *reason.view;
    json.push_back(std::move(entry));
  }
  return json;
}

Json RoundsJson(const std::vector<RoundReport>& rounds) {
  Json json = Json::array();
  for (const RoundReport& round : rounds)
    json.push_back({{"level", round.level},
                    {"num_patches", round.num_patches},
                    {"num_tracks", round.num_tracks},
                    {"num_observations", round.num_observations},
                    {"reprojection_mean_px", NumberJson(round.reprojection_mean_px)},
                    {"reprojection_std_px", NumberJson(round.reprojection_std_px)},
                    {"expected_error_px", Numbers(round.expected_error_px)},
                    {"moved_px", NumberJson(round.moved_px)}});
  return json;
}

Json ViewsPerTrackJson(const std::vector<int>& views_per_track) {
  Json json = Json::array();
  for (std::size_t k = 0; k < views_per_track.size(); ++k)
    if (views_per_track[k] > 0) json.push_back({{"views", k}, {"tracks", views_per_track[k]}});
  return json;
}

Json ViewsJson(const std::vector<ViewFinding>& views) {
  Json json = Json::array();
  for (const ViewFinding& view : views)
    json.push_back({{"name", view.name},
                    {"camera", view.camera},
                    {"moved_px", NumberJson(view.moved_px)},
                    {"direction", {NumberJson(view.direction.x()), NumberJson(view.direction.y())}},
                    {"sigma_px", NumberJson(view.sigma_px)},
                    {"num_features", view.num_features},
                    {"residual_px", NumberJson(view.residual_px)}});
  return json;
}

Json CamerasJson(const std::vector<CameraReport>& cameras) {
  Json json = Json::array();
  for (const CameraReport& report : cameras) {
    Json entry = {{"id", report.camera.id},
                  {"physical_id", report.camera.physical_id},
                  {"width_px", report.camera.width_px},
                  {"height_px", report.camera.height_px}};
    entry.update(IntrinsicsJson(report.camera.Intrinsics()));
    entry["sigma"] = IntrinsicsJson(report.sigma);
    json.push_back(std::move(entry));
  }
  return json;
}

Json MasksJson(const std::vector<MaskReport>& masks) {
  Json json = Json::array();
  for (const MaskReport& mask : masks)
    json.push_back({{"view", mask.view}, {"kind", mask.kind}, {"object_share", NumberJson(mask.object_share)}});
  return json;
}

}  // namespace

const char* NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
      return "accepted";
    case Verdict::kRejected:
      return "rejected";
    case Verdict::kInconclusive:
      break;
  }
  return "inconclusive";
}

std::string ReasonText(const Reason& reason) {
  return fmt::format("{}{}: {:.4g} {} against a limit of {:.4g} {}", reason.check,
                     reason.view ? " (" + *reason.view + ")" : "", reason.value, reason.unit, reason.limit,
                     reason.unit);
}

std::string ReportText(const RunReport& report) {
  const HoldoutError& holdout = report.validation.holdout;
  Json json = {{"format", "rigcal report"}, {"version", kVersion}};
  json["verdict"] = NameOf(report.validation.verdict);
  json["reasons"] = ReasonsJson(report.validation.reasons);
  json["method"] = report.method;
  json["expected_error_px"] = NumberJson(report.expected_error_px);
  json["expected_error_estimated"] = report.expected_error_estimated;
  json["level"] = report.level;
  json["rounds"] = RoundsJson(report.rounds);
  json["views_per_track"] = ViewsPerTrackJson(report.views_per_track);
  json["holdout"] = {{"before_px", holdout.before_px ? NumberJson(*holdout.before_px) : Json()},
                     {"after_px", NumberJson(holdout.after_px)},
                     {"num_tracks", holdout.num_tracks}};
  json["views"] = ViewsJson(report.validation.views);
  json["cameras"] = CamerasJson(report.cameras);
  json["masks"] = MasksJson(report.masks);
  if (report.rig) {
    std::vector<std::string> camera_ids;
    for (const CameraReport& camera : report.cameras) camera_ids.push_back(camera.camera.id);
    json["rig"] = RigFitJson(*report.rig, camera_ids);
    json["contradictions"] = report.contradictions;
  }
  json["notes"] = report.notes;
  return JsonText(json);
}

std::string TimingText(const RunTiming& timing) {
  Json stages = Json::array();
  for (const StageTime& stage : timing.stages) {
    Json entry = {{"stage", stage.stage}};
    if (stage.round >= 0) entry["round"] = stage.round;
    entry["seconds"] = NumberJson(stage.wall_s);
    stages.push_back(std::move(entry));
  }
  return JsonText({{"format", "rigcal timing"},
                   {"version", kVersion},
                   {"total_seconds", NumberJson(timing.total_wall_s)},
                   {"stages", std::move(stages)}});
}

Result<void> WriteReportJson(const RunReport& report, const std::filesystem::path& path) {
  return WriteFileAtomically(path, ReportText(report));
}

Result<void> WriteTimingJson(const RunTiming& timing, const std::filesystem::path& path) {
  return WriteFileAtomically(path, TimingText(timing));
}

}  // namespace rigcal
