#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/scene/recording.h"
#include "core/scene/rig_devices.h"
#include "core/scene/rig_model.h"

namespace rigcal {

/// Its usual name.
inline constexpr const char* kRigFile = "rig.toml";

/// Where the service publishes.
struct PublishSettings {
  std::string rig;                   ///< its name in the store; empty: that of the rig file
  std::filesystem::path folder;      ///< empty: the service's own
  std::vector<std::string> formats;  ///< as ExportFormatFromName knows them
  bool undistorted = false;
};

/// rig.toml: the studio's positioner, how exactly it repeats, and the devices (docs/rig.md, docs/rig_keys.md). A file
/// without devices is one for seeding alone.
struct RigFile {
  RigModel model;                 ///< kind, load and expected errors; geometry is for seeding to find
  std::vector<std::string> axes;  ///< their names in recordings; none for an arm
  PositionerSettings positioner;  ///< without a driver: nothing that rigcal moves; the axes are there all the same
  std::vector<CameraSettings> cameras;
  CaptureSettings capture;
  KeepRule keep;
  PublishSettings publish;
  DriftSettings drift;
  std::optional<SimSettings> sim;        ///< where a device has the driver "sim", or the file has [sim]
  std::optional<ReplaySettings> replay;  ///< where the file has [replay]
  std::filesystem::path board;           ///< of the chart; empty: none
};

/// `file` names it in messages, which tell line, key and allowed range, and its folder is where relative paths begin.
/// Errors: kBadInput: not TOML, a key that is unknown, missing or not one of this kind of positioner, a value of the
/// wrong type or out of range, or parts that contradict each other (config/rig_hardware.h, config/rig_stops.h), or a
/// format that is none.
Result<RigFile> ParseRig(std::string_view text, const std::string& file);

/// Errors: those of ReadFile and ParseRig.
Result<RigFile> LoadRig(const std::filesystem::path& path);

/// The text of a rig.toml with every key of the model, and without devices. Reads back as the same but for the twelfth
/// digit.
std::string RigText(const RigFile& rig);

/// Where the positioner stood at each stop of a recording: as reported, or as commanded where it does not report.
/// `recording_name` names it in messages. Errors: kBadInput with the stop: an axis of the rig or an arm's pose is
/// missing, or in another unit.
Result<std::vector<StopPosition>> StopPositions(const Recording& recording, const RigFile& rig,
                                                const std::string& recording_name);

}  // namespace rigcal
