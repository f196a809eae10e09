#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "drivers/acquire/acquire.h"
#include "drivers/acquire/check_picture.h"

namespace rigcal {

/// Takes the pictures of one stop after another, with what it knows of each camera's last one.
class PictureTaker {
 public:
  PictureTaker(const AcquisitionDevices& devices, const AcquisitionPlan& plan);

  /// A picture of every camera, good or an Error; `keep` gets each good one at once. `stop_id` names the stop in
  /// messages. Errors: see Acquire; those of `keep`.
  Result<void> Take(const std::string& stop_id, const std::vector<int>& cameras,
                    const std::function<Result<void>(int camera, CapturedPicture)>& keep, const std::stop_token& stop);

  [[nodiscard]] int NumRetaken() const { return num_retaken_; }
  [[nodiscard]] int NumRecovered() const { return num_recovered_; }

 private:
  /// What came of one shot of some cameras.
  struct Shot {
    std::vector<std::pair<int, CapturedPicture>> pictures;
    std::map<int, Error> failed;  ///< the camera is to be restored
  };
  /// Fires all together and collects from all that were fired, all within one time. Errors: kCancelled.
  Result<Shot> Shoot(const std::vector<int>& cameras, const std::stop_token& stop);
  /// Brings back what failed, all within the time that is left of recover_s for the stop.
  Result<void> Restore(const std::string& stop_id, const std::map<int, Error>& failed, double& recover_left_s,
                       const std::stop_token& stop);

  const AcquisitionDevices& devices_;
  const AcquisitionPlan& plan_;
  std::vector<PictureCheck> checks_;  ///< per camera
  int num_retaken_ = 0, num_recovered_ = 0;
};

}  // namespace rigcal
