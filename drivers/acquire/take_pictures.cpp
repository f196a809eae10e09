#include "drivers/acquire/take_pictures.h"

#include <algorithm>
#include <utility>

namespace rigcal {

PictureTaker::PictureTaker(const AcquisitionDevices& devices, const AcquisitionPlan& plan)
    : devices_(devices), plan_(plan), checks_(devices.cameras.size(), PictureCheck(plan.settings)) {}

Result<PictureTaker::Shot> PictureTaker::Shoot(const std::vector<int>& cameras, const std::stop_token& stop) {
  Shot shot;
  const auto each = [&](std::vector<int> among, const std::function<Result<void>(int)>& action) {
    std::vector<int> well;
    for (const int camera : among) {
      const Result<void> done = action(camera);
      if (done) well.push_back(camera);
      if (!done) shot.failed.insert_or_assign(camera, done.error());
    }
    return well;
  };
  const std::vector<int> ready = each(cameras, [&](int c) { return devices_.cameras[c]->MakeReady(stop); });
  const std::vector<int> fired = each(ready, [&](int c) { return devices_.cameras[c]->Fire(); });
  const std::string fired_at = plan_.utc_now ? plan_.utc_now() : "";
  const double end_s = devices_.clock->NowS() + plan_.settings.picture_s;
  each(fired, [&](int c) -> Result<void> {
    const double left_s = std::max(0.0, end_s - devices_.clock->NowS());
    Result<CapturedPicture> picture = devices_.cameras[c]->Collect(left_s, stop);
    if (!picture) return Fail(picture.error());
    if (!picture->taken_at && !fired_at.empty()) picture->taken_at = fired_at;
    shot.pictures.emplace_back(c, std::move(*picture));
    return {};
  });
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "taking pictures was stopped on request");
  return shot;
}

Result<void> PictureTaker::Restore(const std::string& stop_id, const std::map<int, Error>& failed,
                                   double& recover_left_s, const std::stop_token& stop) {
  for (const auto& [camera, reason] : failed) {
    const double begin_s = devices_.clock->NowS();
    const Result<void> restored = devices_.cameras[camera]->Restore(recover_left_s, stop);
    recover_left_s = std::max(0.0, recover_left_s - (devices_.clock->NowS() - begin_s));
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "bringing cameras back was stopped on request");
    if (!restored) {
      return Fail(ErrorCode::kDevice, "stop '{}': {} (at first: {})", stop_id, restored.error().message,
                  reason.message);
    }
    ++num_recovered_;
  }
  return {};
}

Result<void> PictureTaker::Take(const std::string& stop_id, const std::vector<int>& cameras,
                                const std::function<Result<void>(int camera, CapturedPicture)>& keep,
                                const std::stop_token& stop) {
  double recover_left_s = plan_.settings.recover_s;
  std::vector<int> wanted = cameras;
  std::string reason;
  for (int attempt = 0; attempt <= plan_.settings.retakes && !wanted.empty(); ++attempt) {
    if (attempt > 0) {
      num_retaken_ += static_cast<int>(wanted.size());
      devices_.clock->Wait(plan_.settle_s, stop);
    }
    Result<Shot> shot = Shoot(wanted, stop);
    if (!shot) return Fail(shot.error());
    wanted.clear();
    for (auto& [camera, picture] : shot->pictures) {
      if (const auto fault = checks_[camera].Judge(picture.pixels)) {
        wanted.push_back(camera);
        reason = fmt::format("camera '{}': {}", devices_.cameras[camera]->Identity().id, *fault);
      } else if (Result<void> kept = keep(camera, std::move(picture)); !kept) {
        return kept;
      }
    }
    if (Result<void> restored = Restore(stop_id, shot->failed, recover_left_s, stop); !restored) return restored;
    for (const auto& [camera, error] : shot->failed) {
      wanted.push_back(camera);
      reason = error.message;
    }
    std::ranges::sort(wanted);
  }
  if (wanted.empty()) return {};
  const int retakes = plan_.settings.retakes;
  return Fail(ErrorCode::kDevice, "stop '{}': {}{}", stop_id, reason,
              retakes > 0 ? fmt::format(", also after {} retakes", retakes) : "");
}

}  // namespace rigcal
