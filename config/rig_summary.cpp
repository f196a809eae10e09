#include "config/rig_summary.h"

#include <algorithm>

#include "config/positioner_names.h"
#include "config/rig_keys.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

/// A value of an axis in the unit of the file.
std::string InFileUnit(double value, AxisUnit unit) {
  return unit == AxisUnit::kRadian ? fmt::format("{:.6g} deg", value / kRadPerDeg) : fmt::format("{:.6g} m", value);
}

std::string PositionerLine(const RigFile& rig) {
  const Positioner& positioner = rig.model.positioner;
  std::string line = fmt::format("positioner: {}, carries {}", WordOf(kPositionerKinds, positioner.kind),
                                 positioner.load == PositionerLoad::kObject ? "the object" : "the cameras");
  const PositionerSettings& device = rig.positioner;
  if (device.driver.empty()) return line + "; no driver, stops are made by hand\n";
  line += fmt::format("; driver {}", device.driver);
  if (!device.address.empty()) line += fmt::format(" at {}", device.address);
  return line + fmt::format(", settles {:.6g} s\n", device.settle_s);
}

std::string AxisLine(const AxisSettings& axis) {
  std::string line = fmt::format("axis {}:", axis.name);
  if (!axis.device_letter.empty()) line += fmt::format(" {},", axis.device_letter);
  line += axis.least && axis.most
              ? fmt::format(" {} to {}", InFileUnit(*axis.least, axis.unit), InFileUnit(*axis.most, axis.unit))
              : " no soft limits";
  if (axis.speed > 0) line += fmt::format(", {}/s", InFileUnit(axis.speed, axis.unit));
  if (axis.approach != 0)
    line += fmt::format(", reached while it {}, from {} beyond", axis.approach > 0 ? "grows" : "shrinks",
                        InFileUnit(axis.backlash, axis.unit));
  return line + "\n";
}

std::string StopsLine(const RigFile& rig) {
  const std::vector<std::vector<double>>& stops = rig.capture.stops;
  if (stops.empty()) return rig.axes.empty() ? "stops: the arm tells them\n" : "stops: none\n";
  std::vector<std::string> ranges;
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    double least = stops[0][a], most = least;
    for (const std::vector<double>& stop : stops) least = std::min(least, stop[a]), most = std::max(most, stop[a]);
    const AxisUnit unit = rig.positioner.axes[a].unit;
    ranges.push_back(fmt::format("{} {} to {}", rig.axes[a], InFileUnit(least, unit), InFileUnit(most, unit)));
  }
  return fmt::format("stops: {}, {}\n", stops.size(), Joined(ranges, ", "));
}

std::string CameraLine(const CameraSettings& camera) {
  std::string line = fmt::format("camera {}: {}", camera.id, camera.driver);
  if (!camera.serial.empty()) line += ", serial " + camera.serial;
  if (!camera.address.empty()) line += ", address " + camera.address;
  line += ", " + camera.pixel_format;
  if (camera.exposure_us) line += fmt::format(", {:.6g} us", *camera.exposure_us);
  if (camera.gain_db) line += fmt::format(", {:.6g} dB", *camera.gain_db);
  if (camera.trigger == CameraTrigger::kHardware) line += ", hardware trigger";
  return line + "\n";
}

std::string KeepLine(const KeepRule& keep) {
  std::vector<std::string> parts;
  if (keep.max_age_days) parts.push_back(fmt::format("{:.6g} days", *keep.max_age_days));
  if (keep.max_count) parts.push_back(fmt::format("at most {}", *keep.max_count));
  if (keep.min_free_bytes)
    parts.push_back(fmt::format("{:.6g} GB of the disk free", *keep.min_free_bytes / kBytesPerGb));
  return parts.empty() ? "recordings: all are kept\n" : fmt::format("recordings: {}\n", Joined(parts, ", "));
}

std::string PublishLine(const PublishSettings& publish) {
  std::string line;
  if (!publish.rig.empty()) line += fmt::format("rig '{}' of the store; ", publish.rig);
  line += publish.folder.empty() ? "published in the state folder" : "published in " + publish.folder.string();
  if (!publish.formats.empty()) line += ", also as " + Joined(publish.formats, ", ");
  return line + "\n";
}

}  // namespace

std::string RigSummaryText(const RigFile& rig) {
  std::string text = PositionerLine(rig);
  for (const AxisSettings& axis : rig.positioner.axes) text += AxisLine(axis);
  text += StopsLine(rig);
  if (rig.cameras.empty()) text += "cameras: none\n";
  for (const CameraSettings& camera : rig.cameras) text += CameraLine(camera);
  if (!rig.board.empty()) text += fmt::format("chart: {}\n", rig.board.string());
  if (rig.replay) text += fmt::format("replay: {}\n", rig.replay->recording);
  if (rig.sim)
    text += fmt::format("simulated studio: {}, {} cameras of {} x {} px\n", rig.sim->scene, rig.sim->num_cameras,
                        rig.sim->width_px, rig.sim->height_px);
  const PublishSettings& publish = rig.publish;
  if (!publish.rig.empty() || !publish.folder.empty() || !publish.formats.empty()) text += PublishLine(publish);
  return text + KeepLine(rig.keep);
}

}  // namespace rigcal
