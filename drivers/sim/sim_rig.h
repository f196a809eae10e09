#pragma once

#include <mutex>
#include <set>
#include <string>

#include "core/base/clock.h"
#include "drivers/driver.h"
#include "sim_fixtures/truth_file.h"

namespace rigcal {

/// What can be wrong with a simulated camera.
struct SimCameraFaults {
  bool silent = false;   ///< pictures do not come
  bool damaged = false;  ///< pictures come incomplete
  bool gone = false;     ///< it does not answer
  bool frozen = false;   ///< gives its last picture again
  bool blinded = false;  ///< over-exposed: all of the picture is saturated
};

/// What can be wrong with a simulated table.
struct SimTableFaults {
  bool no_home = false;  ///< homing fails
  bool alarm = false;    ///< raised once the next move is under way
  bool gone = false;     ///< the connection is lost once the next move is under way
  bool stuck = false;    ///< it never moves
  double miss_rad = 0;   ///< it ends so far beyond its target
};

/// The table's motion: at constant speed from where it was when it was told. Safe to use from several threads.
class SimTable {
 public:
  explicit SimTable(Clock& clock) : clock_(clock) {}

  void Start(double target_rad, double speed_rad_s);
  void Halt();
  [[nodiscard]] double Angle() const;
  [[nodiscard]] bool Moving() const;
  [[nodiscard]] SimTableFaults Faults() const;
  void SetFaults(const SimTableFaults& faults);

 private:
  [[nodiscard]] double AngleLocked() const;

  Clock& clock_;
  mutable std::mutex mutex_;
  double from_rad_ = 0, to_rad_ = 0, begin_s_ = 0, speed_rad_s_ = 1;
  SimTableFaults faults_;
};

/// What the simulated devices of a rig share: the studio with its table, and the faults of its cameras. Pictures are
/// taken by one thread.
class SimRig {
 public:
  SimRig(sim::Studio studio, const sim::ShotOptions& shot, Clock& clock);

  SimTable& Table() { return table_; }
  [[nodiscard]] Clock& Time() const { return clock_; }
  [[nodiscard]] const sim::Studio& Content() const { return studio_; }

  /// The picture of a camera with the table at this angle. `attempt` counts the camera's pictures at the angle from 0
  /// and changes the noise alone. 8 or 16 bits. Errors: kCancelled.
  Result<cv::Mat> Picture(int camera, double angle_rad, int attempt, int bits, const std::stop_token& stop);

  [[nodiscard]] SimCameraFaults Faults(int camera) const;
  void SetFaults(int camera, const SimCameraFaults& faults);

  /// One opens a camera at a time; false when somebody has it.
  bool Hold(int camera);
  void Free(int camera);

 private:
  sim::Studio studio_;
  const sim::ShotOptions shot_;
  Clock& clock_;
  SimTable table_;
  mutable std::mutex mutex_;
  std::vector<SimCameraFaults> faults_;
  std::set<int> held_;
};

}  // namespace rigcal
