#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "config/calibration_store.h"
#include "core/base/clock.h"
#include "core/base/result.h"

namespace rigcal {

/// The revision in force as a file: its calibration.json with the key "revision" (docs/store.md).
inline constexpr const char* kCurrentFile = "current.json";

/// A format of `rigcal export` in which the revision in force is wanted, too.
struct PublishedFormat {
  std::string format;  ///< "colmap", as ExportFormatFromName knows it
  bool undistorted = false;
};

/// Where programs that know nothing of the store find the revision in force of one rig.
struct PublishFolder {
  std::filesystem::path folder;
  std::vector<PublishedFormat> formats;
};

struct Published {
  PublishEvent event;
  std::vector<std::string> notes;  ///< of the exports, sentences
};

/// Publishes in the store, then in the folder. Every format is written before the pointer moves, so that one which
/// cannot hold the revision, or whose place is taken by something else or another rig, is refused without a change;
/// each then gets its name by an atomic rename, current.json last. All files may be read by everybody. The folder is
/// locked meanwhile: who comes second waits (by the clock, until the stop token is set or kTimeout). When the pointer
/// has moved and the folder fails, the message says so; that and a crash in between are mended by RepairPublished.
/// Errors: those of the store, Export and PrepareOutputFolder; kIo, kDiskFull.
Result<Published> PublishRevision(CalibrationStore& store, const PublishRequest& request, const PublishFolder& target,
                                  Clock& clock, const std::stop_token& stop);

/// Makes the folder show what the store says: for the start of the service. True: something was written; false: it was
/// right, or the store has nothing in force. Errors: as PublishRevision.
Result<bool> RepairPublished(CalibrationStore& store, const std::string& rig, const PublishFolder& target, Clock& clock,
                             const std::stop_token& stop);

/// What current.json says of a revision that was published with `event`. Errors: those of ParseCalibration.
Result<std::string> CurrentText(const CalibrationRevision& revision, const PublishEvent& event,
                                const std::vector<PublishedFormat>& formats);

}  // namespace rigcal
