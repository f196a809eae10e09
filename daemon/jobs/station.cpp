#include "daemon/jobs/station.h"

#include <string_view>
#include <utility>

#include "config/read_file.h"
#include "config/store/sqlite_store.h"

namespace rigcal {
namespace {

/// Of a kName of the rig file; the name of a file may hold others.
constexpr std::string_view kNameCharacters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";

}  // namespace

std::filesystem::path Station::StoreFile() const {
  return state / kStoreFile;
}

std::filesystem::path Station::JobFolder(int job) const {
  return state / "jobs" / fmt::format("{:06}", job);
}

Result<Station> LoadStation(const std::filesystem::path& rig_file, const std::filesystem::path& state,
                            int num_threads) {
  Station station{.rig_file = std::filesystem::absolute(rig_file),
                  .state = std::filesystem::absolute(state),
                  .num_threads = num_threads};
  Result<std::string> text = ReadFile(station.rig_file);
  if (!text) return Fail(text.error());
  Result<RigFile> rig = ParseRig(*text, station.rig_file.string());
  if (!rig) return Fail(rig.error());
  station.rig_text = std::move(*text);
  station.rig = std::move(*rig);
  const PublishSettings& publish = station.rig.publish;
  station.name = publish.rig.empty() ? station.rig_file.stem().string() : publish.rig;
  if (station.name.find_first_not_of(kNameCharacters) != std::string::npos) {
    return Fail(ErrorCode::kBadInput, "{}: '{}' names no rig in the store; [publish] rig gives it a name",
                station.rig_file.string(), station.name);
  }
  station.publish.folder = publish.folder.empty() ? station.state / "published" : publish.folder;
  for (const std::string& format : publish.formats) {
    station.publish.formats.push_back({format, publish.undistorted});
  }
  return station;
}

}  // namespace rigcal
