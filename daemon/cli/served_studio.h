#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/scene/recording.h"
#include "sim_fixtures/gige/gige_device.h"
#include "sim_fixtures/grbl/grbl_simulator.h"
#include "sim_fixtures/linuxcnc/linuxcnc_simulator.h"

namespace rigcal {

/// How the pictures travel.
struct ServedNetwork {
  double loss = 0;             ///< share of the stream's packets
  bool can_resend = true;      ///< lost packets are sent again on request
  double bits_per_second = 0;  ///< of each camera; 0: as quickly as the machine can
  std::uint64_t random_seed = 1;
};

/// What moves the table: GRBL's X axis on a pseudo-terminal, or LinuxCNC's C axis.
enum class ServedMotion { kGrbl, kLinuxcnc };

/// A recording of a turntable behind real protocols: a GigE Vision camera for each of its cameras, and a table. A
/// camera that is triggered sees the recording's picture of the stop at which the table stands, and black where it
/// stands at none.
class ServedStudio {
 public:
  /// All pictures are read at once: 8 bits, or 16, one channel. Errors: those of reading them; kUnsupported (another
  /// kind of recording or picture), kIo (no address or terminal to be had).
  static Result<std::unique_ptr<ServedStudio>> Start(const std::string& folder, const ServedNetwork& network,
                                                     ServedMotion motion, Clock& clock);

  /// "GRBL at /dev/pts/3, X in degrees"
  [[nodiscard]] std::string TableText() const;
  [[nodiscard]] const std::vector<std::unique_ptr<sim::GigeDevice>>& Cameras() const { return cameras_; }
  [[nodiscard]] const std::string& IdOf(std::size_t camera) const { return recording_.cameras.at(camera).id; }

 private:
  explicit ServedStudio(Recording recording) : recording_(std::move(recording)) {}
  Result<void> StartTable(ServedMotion motion, Clock& clock);
  double TableAngle_deg();
  cv::Mat See(int camera, const sim::GigeShot& shot);

  Recording recording_;
  std::vector<cv::Mat> pictures_;                          ///< per view
  std::unique_ptr<sim::GrblSimulator> grbl_;               ///< this one or
  std::unique_ptr<sim::LinuxcncSimulator> linuxcnc_;       ///< that one is the table
  std::vector<std::unique_ptr<sim::GigeDevice>> cameras_;  ///< last: their threads use all of the above
};

}  // namespace rigcal
