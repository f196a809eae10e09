#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "drivers/arm/arm.h"
#include "drivers/driver.h"

namespace rigcal {

/// An arm whose poses a file lists beforehand, one `K x y z qw qx qy qz` a line, '#' begins a comment. Where somebody
/// can be asked (DriverContext::confirm), he says that the arm is there; otherwise it keeps to the list by itself, and
/// the settle time is its pace.
class ListedArm final : public Arm {
 public:
  /// Errors: kNotFound, kIo; kBadInput with file and line: not a pose, a name twice, no pose at all.
  static Result<std::unique_ptr<PositionerDevice>> Open(const PositionerSettings& settings,
                                                        const DriverContext& context);

  Result<std::optional<RecordedStop>> NextStop(const std::stop_token& stop) override;
  Result<void> FinishStop(const Result<void>& /*taken*/) override { return {}; }
  void Halt() noexcept override {}  // rigcal does not move it

 private:
  ListedArm(std::vector<RecordedStop> stops, double timeout_s, const DriverContext& context);

  std::vector<RecordedStop> stops_;
  double timeout_s_;
  std::function<Result<void>(const std::string& what, double timeout_s, const std::stop_token& stop)> confirm_;
  std::size_t next_ = 0;
};

}  // namespace rigcal
