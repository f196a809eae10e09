#include "config/drift_report.h"

#include <algorithm>

#include "config/json_content.h"
#include "config/json_text.h"
#include "config/utc_text.h"
#include "core/drift/drift_sentences.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr DocumentFormat kFormat{"rigcal drift", 1};
constexpr double kSecondsPerDay = 86400;

Json PairJson(const Eigen::Vector2d& pair) {
  return {NumberJson(pair.x()), NumberJson(pair.y())};
}

Json MotionJson(const CameraDrift& drift) {
  const PictureMotion& motion = drift.motion;
  const double length_px = motion.shift_px.norm();
  const Eigen::Vector2d direction =
      length_px > 0 ? Eigen::Vector2d(motion.shift_px / length_px) : Eigen::Vector2d::Zero();
  return {{"moved_px", NumberJson(motion.moved_px)},
          {"sigma_px", NumberJson(motion.sigma_px)},
          {"shift_px", PairJson(motion.shift_px)},
          {"shift_sigma_px", PairJson(motion.shift_sigma_px)},
          {"direction", PairJson(direction)},
          {"chi_square", NumberJson(drift.chi_square)},
          {"moved", drift.moved}};
}

Json CameraJson(const CameraDrift& drift) {
  Json json = {{"camera", drift.camera}};
  json.update(MotionJson(drift));
  const auto number = [](const std::optional<double>& px) { return px ? NumberJson(*px) : Json(nullptr); };
  json["num_features"] = drift.evidence.num_features;
  json["holdout"] = {{"before_px", number(drift.evidence.before_px)}, {"after_px", number(drift.evidence.after_px)}};
  return json;
}

Json ReasonsJson(const std::vector<DriftReason>& reasons) {
  Json json = Json::array();
  for (const DriftReason& reason : reasons) {
    Json entry = {{"check", reason.check},
                  {"value", NumberJson(reason.value)},
                  {"limit", NumberJson(reason.limit)},
                  {"unit", reason.unit}};
    if (reason.camera) entry["camera"] = *reason.camera;
    json.push_back(std::move(entry));
  }
  return json;
}

Json TrendJson(const std::vector<CameraTrend>& trend) {
  Json json = Json::array();
  for (const CameraTrend& camera : trend) {
    json.push_back({{"camera", camera.camera},
                    {"num_nights", camera.num_nights},
                    {"px_per_day", PairJson(camera.px_per_day)},
                    {"sigma_px_per_day", PairJson(camera.sigma_px_per_day)}});
  }
  return json;
}

/// Throws BadContent unless both are numbers; a null, which a number that was not finite became, is no measurement.
std::optional<Eigen::Vector2d> PairFrom(const Json& json) {
  if (!json.is_array() || json.size() != 2) Refuse("a pair of numbers is needed");
  if (json[0].is_null() || json[1].is_null()) return std::nullopt;
  return Eigen::Vector2d(json[0].get<double>(), json[1].get<double>());
}

std::optional<double> DaysFrom(const std::optional<std::string>& utc) {
  const auto time = utc ? TimeFromUtc(*utc) : std::nullopt;
  if (!time) return std::nullopt;
  return std::chrono::duration<double>(time->time_since_epoch()).count() / kSecondsPerDay;
}

EarlierNight NightFrom(const Json& json) {
  EarlierNight earlier{.recording_id = json.at("recording").at("id").get<std::string>(),
                       .calibration_sha256 = json.at("calibration_sha256").get<std::string>()};
  const Json& recorded_at = json.at("recording").at("recorded_at");
  DriftNight night;
  for (const Json& camera : List(json, "cameras")) {
    const auto shift_px = PairFrom(camera.at("shift_px")), sigma_px = PairFrom(camera.at("shift_sigma_px"));
    if (shift_px && sigma_px) night.cameras.push_back({camera.at("camera").get<std::string>(), *shift_px, *sigma_px});
  }
  if (recorded_at.is_null()) return earlier;
  const auto days = DaysFrom(recorded_at.get<std::string>());
  if (!days) Refuse("recorded_at is '{}', a time like 2025-01-31T12:00:00Z is needed", recorded_at.get<std::string>());
  night.time_days = *days;
  earlier.night = std::move(night);
  return earlier;
}

}  // namespace

std::string DriftText(const DriftReport& report) {
  const DriftFinding& finding = report.finding;
  Json json = {{"format", kFormat.name}, {"version", kFormat.version}, {"state", NameOf(finding.state)}};
  json["limit_px"] = NumberJson(finding.limit_px);
  json["sentences"] = finding.sentences;
  json["reasons"] = ReasonsJson(finding.reasons);
  json["suspects"] = finding.suspects;
  json["which_is_told"] = finding.which_is_told;
  json["cameras"] = Json::array();
  for (const CameraDrift& drift : finding.cameras) json["cameras"].push_back(CameraJson(drift));
  if (finding.together) json["together"] = MotionJson(*finding.together);
  json["recording"] = {{"id", report.recording_id},
                       {"recorded_at", report.recorded_at ? Json(*report.recorded_at) : Json(nullptr)}};
  json["calibration_sha256"] = report.calibration_sha256;
  json["trend"] = TrendJson(report.trend);
  json["notes"] = report.notes;
  return JsonText(json);
}

Result<EarlierNight> ParseEarlierNight(std::string_view text, const std::string& file) {
  return ReadDocument<EarlierNight>(text, file, kFormat, NightFrom);
}

std::vector<DriftNight> NightsWith(const DriftReport& tonight, const std::vector<EarlierNight>& earlier) {
  const auto days = DaysFrom(tonight.recorded_at);
  if (!days) return {};
  std::vector<DriftNight> nights;
  std::vector<std::string> counted = {tonight.recording_id};
  for (const EarlierNight& night : earlier) {
    const bool known = std::ranges::find(counted, night.recording_id) != counted.end();
    if (known || !night.night || night.calibration_sha256 != tonight.calibration_sha256) continue;
    counted.push_back(night.recording_id);
    nights.push_back(*night.night);
  }
  DriftNight last{.time_days = *days};
  for (const CameraDrift& drift : tonight.finding.cameras) {
    last.cameras.push_back({drift.camera, drift.motion.shift_px, drift.motion.shift_sigma_px});
  }
  nights.push_back(std::move(last));
  return nights;
}

}  // namespace rigcal
