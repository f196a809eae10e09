#include "daemon/store_diff.h"

#include <fmt/format.h>

#include "config/calibration_file.h"
#include "config/json_text.h"
#include "core/base/joined.h"
#include "core/geometry/shift_text.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

/// Of two cameras each has moved against the other as far as the other against it.
constexpr std::size_t kMinCamerasToTell = 3;

Result<RigCalibration> CalibrationOf(const CalibrationRevision& revision) {
  const std::string name = fmt::format("revision {}", revision.head.number);
  auto content = ParseCalibration(revision.calibration_text, name);
  if (!content) return Fail(content.error());
  return std::move(content->calibration);
}

std::string SigmaText(const CameraMotion& motion) {
  if (!motion.sigma_px) return "sigma not stated";
  return fmt::format("sigma {:.2f} px, {} its sigma ({:.1f} times)", *motion.sigma_px,
                     motion.MovedMoreThanSigma() ? "more than" : "within", motion.moved_px / *motion.sigma_px);
}

std::string OnlyText(const std::vector<std::string>& cameras, int revision) {
  if (cameras.empty()) return "";
  return fmt::format("only in revision {}: {}\n", revision, Joined(cameras, ", "));
}

}  // namespace

Result<RevisionDiff> DiffRevisions(CalibrationStore& store, const std::string& rig, int before, int after) {
  const auto a = store.Load(rig, before);
  if (!a) return Fail(a.error());
  const auto b = store.Load(rig, after);
  if (!b) return Fail(b.error());
  const auto was = CalibrationOf(*a);
  if (!was) return Fail(was.error());
  const auto is = CalibrationOf(*b);
  if (!is) return Fail(is.error());
  auto difference = CompareCalibrations(*was, *is);
  if (!difference) return Fail(difference.error());
  return RevisionDiff{a->head, b->head, std::move(*difference)};
}

std::string DiffText(const RevisionDiff& diff) {
  const CalibrationDifference& d = diff.difference;
  std::string text = fmt::format("revision {} ({}) to {} ({}): {:.2f} px at the object, mean of {} views {}\n",
                                 diff.before.number, diff.before.time, diff.after.number, diff.after.time, d.mean_px,
                                 d.num_views, d.by_rig ? "at the rig's exact stops" : "of the same name");
  for (const CameraMotion& motion : d.cameras) {
    text += fmt::format("  {:16} {:.2f} px: the picture moved {} on average; {}\n", motion.camera, motion.moved_px,
                        ShiftText(motion.shift_px), SigmaText(motion));
  }
  text += OnlyText(d.only_before, diff.before.number) + OnlyText(d.only_after, diff.after.number);
  if (d.cameras.size() < kMinCamerasToTell) {
    text += "with fewer than three cameras it cannot be told which one moved\n";
  }
  return text;
}

std::string DiffJson(const RevisionDiff& diff) {
  const CalibrationDifference& d = diff.difference;
  Json cameras = Json::array();
  for (const CameraMotion& motion : d.cameras) {
    cameras.push_back({{"camera", motion.camera},
                       {"num_views", motion.num_views},
                       {"moved_px", NumberJson(motion.moved_px)},
                       {"shift_px", {NumberJson(motion.shift_px.x()), NumberJson(motion.shift_px.y())}},
                       {"direction", {NumberJson(motion.direction.x()), NumberJson(motion.direction.y())}},
                       {"sigma_px", motion.sigma_px ? NumberJson(*motion.sigma_px) : Json(nullptr)},
                       {"more_than_sigma", motion.MovedMoreThanSigma()}});
  }
  return JsonText({{"rig", diff.before.rig},
                   {"before", diff.before.number},
                   {"after", diff.after.number},
                   {"by_rig", d.by_rig},
                   {"num_views", d.num_views},
                   {"mean_px", NumberJson(d.mean_px)},
                   {"cameras", std::move(cameras)},
                   {"only_before", d.only_before},
                   {"only_after", d.only_after}});
}

}  // namespace rigcal
