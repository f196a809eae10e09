#include "drivers/arm/listed_arm.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <system_error>

#include "drivers/arm/pose_line.h"

namespace rigcal {
namespace {

Result<std::vector<RecordedStop>> ReadPoses(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return Fail(ErrorCode::kNotFound, "arm: {} is neither HOST:PORT to listen on nor a file of poses", file);
  }
  std::ifstream in(file);
  std::vector<RecordedStop> stops;
  std::map<std::string, int> line_of;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    Result<RecordedStop> stop = ParsePose(line);
    if (!stop) return Fail(ErrorCode::kBadInput, "arm: {} line {}: {}", file, number, stop.error().message);
    const auto [named, is_new] = line_of.emplace(stop->id, number);
    if (!is_new) {
      return Fail(ErrorCode::kBadInput, "arm: {} line {}: the stop '{}' is in line {} already", file, number, stop->id,
                  named->second);
    }
    stops.push_back(std::move(*stop));
  }
  if (in.bad() || !in.eof()) return Fail(ErrorCode::kIo, "arm: {}: cannot be read", file);
  if (stops.empty()) return Fail(ErrorCode::kBadInput, "arm: {}: has no pose", file);
  return stops;
}

}  // namespace

ListedArm::ListedArm(std::vector<RecordedStop> stops, double timeout_s, const DriverContext& context)
    : stops_(std::move(stops)), timeout_s_(timeout_s), confirm_(context.confirm) {}

Result<std::unique_ptr<PositionerDevice>> ListedArm::Open(const PositionerSettings& settings,
                                                          const DriverContext& context) {
  Result<std::vector<RecordedStop>> stops = ReadPoses(settings.address);
  if (!stops) return Fail(stops.error());
  return std::unique_ptr<PositionerDevice>(new ListedArm(std::move(*stops), settings.move_timeout_s, context));
}

Result<std::optional<RecordedStop>> ListedArm::NextStop(const std::stop_token& stop) {
  if (stop.stop_requested())
    return Fail(ErrorCode::kCancelled, "arm: waiting for its next stop was stopped on request");
  if (next_ == stops_.size()) return std::optional<RecordedStop>();
  const RecordedStop& next = stops_[next_];
  if (confirm_) {
    const std::string what = fmt::format("arm: bring it to stop '{}' ({} of {})", next.id, next_ + 1, stops_.size());
    if (Result<void> there = confirm_(what, timeout_s_, stop); !there) return Fail(there.error());
  }
  ++next_;
  return std::optional(next);
}

}  // namespace rigcal
