#include "daemon/cli/served_studio.h"

#include <cmath>
#include <numbers>

#include "daemon/recorded_pictures_source.h"

namespace rigcal {
namespace {

constexpr double kSameAngle_deg = 0.05;  ///< the table's steps are 1/250 of a degree
constexpr double kTurn_deg = 360;
constexpr sim::AxisValues kZeroWhereHomingEnds = {-1, 0, 0};  ///< at the pull-off from the switch

Result<void> CheckServable(const Recording& recording, const std::string& folder) {
  for (const RecordedStop& stop : recording.stops) {
    if (stop.axes.size() != 1 || stop.axes.front().unit != AxisUnit::kRadian) {
      return Fail(ErrorCode::kUnsupported, "{}: stop '{}' is not that of a turntable", folder, stop.id);
    }
  }
  if (!recording.cameras.empty() && !recording.stops.empty()) return {};
  return Fail(ErrorCode::kUnsupported, "{}: has {} cameras and {} stops, there is nothing to serve", folder,
              recording.cameras.size(), recording.stops.size());
}

}  // namespace

Result<std::unique_ptr<ServedStudio>> ServedStudio::Start(const std::string& folder, const ServedNetwork& network,
                                                          ServedMotion motion, Clock& clock) {
  Result<RecordedPictures> recorded = OpenRecordedPictures(folder);
  if (!recorded) return Fail(recorded.error());
  if (Result<void> servable = CheckServable(recorded->recording, folder); !servable) return Fail(servable.error());
  std::unique_ptr<ServedStudio> studio(new ServedStudio(recorded->recording));
  for (std::size_t v = 0; v < recorded->recording.views.size(); ++v) {
    Result<CapturedPicture> picture = recorded->load(static_cast<int>(v));
    if (!picture) return Fail(picture.error());
    if (picture->pixels.channels() != 1) {
      return Fail(ErrorCode::kUnsupported, "{}: {} has {} channels, only grey pictures are served", folder,
                  recorded->recording.views[v].file, picture->pixels.channels());
    }
    studio->pictures_.push_back(std::move(picture->pixels));
  }
  if (Result<void> table = studio->StartTable(motion, clock); !table) return Fail(table.error());
  for (std::size_t c = 0; c < studio->recording_.cameras.size(); ++c) {
    const RecordedCamera& camera = studio->recording_.cameras[c];
    sim::GigeDeviceOptions options{.can_resend = network.can_resend,
                                   .bits_per_second = network.bits_per_second,
                                   .random_seed = network.random_seed + c};
    options.camera.serial = "SIM-" + camera.id;
    options.camera.width_px = camera.width_px;
    options.camera.height_px = camera.height_px;
    auto device = sim::GigeDevice::Start(
        options, [raw = studio.get(), c](const sim::GigeShot& shot) { return raw->See(static_cast<int>(c), shot); });
    if (!device) return Fail(device.error());
    (*device)->Set({.loss = network.loss});
    studio->cameras_.push_back(std::move(*device));
  }
  return studio;
}

Result<void> ServedStudio::StartTable(ServedMotion motion, Clock& clock) {
  if (motion == ServedMotion::kGrbl) {
    Result<std::unique_ptr<sim::GrblSimulator>> grbl = sim::GrblSimulator::Start(clock);
    if (!grbl) return Fail(grbl.error());
    grbl_ = std::move(*grbl);
    grbl_->With([](sim::GrblMachine& machine) { machine.SetWorkOffset(kZeroWhereHomingEnds); });
    return {};
  }
  Result<std::unique_ptr<sim::LinuxcncSimulator>> linuxcnc = sim::LinuxcncSimulator::Start(clock);
  if (!linuxcnc) return Fail(linuxcnc.error());
  linuxcnc_ = std::move(*linuxcnc);
  linuxcnc_->With([](sim::LinuxcncMachine& machine) { machine.SetEmergencyStop(false, false); });
  return {};
}

std::string ServedStudio::TableText() const {
  if (grbl_) return fmt::format("GRBL at {}, X in degrees", grbl_->Path());
  return fmt::format("LinuxCNC at {}, C in degrees", linuxcnc_->Address());
}

double ServedStudio::TableAngle_deg() {
  double angle_deg = 0;
  if (grbl_) grbl_->With([&](sim::GrblMachine& machine) { angle_deg = machine.PositionInWork()[0]; });
  if (linuxcnc_) linuxcnc_->With([&](sim::LinuxcncMachine& machine) { angle_deg = machine.Position('C'); });
  return angle_deg;
}

/// Called by the cameras' threads; the pictures do not change.
cv::Mat ServedStudio::See(int camera, const sim::GigeShot& shot) {
  const double angle_deg = TableAngle_deg();
  const int type = shot.format.BytesPerPixel() > 1 ? CV_16U : CV_8U;
  const cv::Rect region(shot.left_px, shot.top_px, shot.width_px, shot.height_px);
  for (std::size_t v = 0; v < recording_.views.size(); ++v) {
    const RecordedView& view = recording_.views[v];
    if (view.camera != camera || !view.stop || pictures_[v].type() != type) continue;
    const double stop_deg = recording_.stops[*view.stop].axes.front().commanded * 180 / std::numbers::pi;
    if (std::abs(std::remainder(angle_deg - stop_deg, kTurn_deg)) > kSameAngle_deg) continue;
    return pictures_[v](region).clone();
  }
  return cv::Mat::zeros(region.size(), type);
}

}  // namespace rigcal
