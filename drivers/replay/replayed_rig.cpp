#include "drivers/replay/replayed_rig.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/base/joined.h"

namespace rigcal {
namespace {

constexpr double kSamePlace = 1e-9;  ///< radians or metres: what is left of a number after a way through a text

/// Seconds since 1970 of a recording's `taken_at`.
std::optional<double> SecondsOf(const std::string& utc) {
  int year = 0;
  unsigned month = 0, day = 0, hour = 0, minute = 0;
  double second = 0;
  if (std::sscanf(utc.c_str(), "%d-%u-%uT%u:%u:%lfZ", &year, &month, &day, &hour, &minute, &second) != 6) {
    return std::nullopt;
  }
  const std::chrono::sys_days date =
      std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(month), std::chrono::day(day));
  return 86400.0 * static_cast<double>(date.time_since_epoch().count()) + 3600.0 * hour + 60.0 * minute + second;
}

bool SamePlace(const std::vector<AxisPosition>& recorded, const std::vector<double>& target) {
  return !target.empty() && std::equal(recorded.begin(), recorded.end(), target.begin(), target.end(),
                                       [](const AxisPosition& axis, double value) {
                                         return std::abs(axis.commanded - value) <= kSamePlace;
                                       });
}

}  // namespace

ReplayedRig::ReplayedRig(RecordedPictures pictures, Subject subject, bool at_recorded_speed, Clock& clock)
    : pictures_(std::move(pictures)), subject_(subject), at_recorded_speed_(at_recorded_speed), clock_(clock) {}

Result<int> ReplayedRig::FindStop(const StopTarget& target) const {
  const std::vector<RecordedStop>& stops = Content().stops;
  const auto same_id = std::ranges::find(stops, target.id, &RecordedStop::id);
  if (same_id != stops.end() && (target.axes.empty() || SamePlace(same_id->axes, target.axes))) {
    return static_cast<int>(same_id - stops.begin());
  }
  const auto same_place =
      std::ranges::find_if(stops, [&](const RecordedStop& stop) { return SamePlace(stop.axes, target.axes); });
  if (same_place != stops.end()) return static_cast<int>(same_place - stops.begin());
  std::vector<std::string> place;
  for (const double value : target.axes) place.push_back(fmt::format("{}", value));
  return Fail(ErrorCode::kDevice, "replay: the recording '{}' has no stop '{}' at ({})", Content().id, target.id,
              Joined(place, ", "));
}

std::optional<double> ReplayedRig::TakenAtS(int stop) const {
  std::optional<double> first_s;
  for (const RecordedView& view : Content().views) {
    if (view.stop != stop || !view.taken_at) continue;
    const std::optional<double> taken_s = SecondsOf(*view.taken_at);
    if (taken_s && (!first_s || *taken_s < *first_s)) first_s = taken_s;
  }
  return first_s;
}

Result<void> ReplayedRig::GoTo(int stop, const std::stop_token& token) {
  const std::optional<double> taken_s = at_recorded_speed_ ? TakenAtS(stop) : std::nullopt;
  if (taken_s) {
    if (!clock_minus_recorded_s_) clock_minus_recorded_s_ = clock_.NowS() - *taken_s;
    clock_.Wait(*clock_minus_recorded_s_ + *taken_s - clock_.NowS(), token);
  }
  if (token.stop_requested()) return Fail(ErrorCode::kCancelled, "replay: the move was stopped on request");
  const std::lock_guard lock(mutex_);
  current_stop_ = stop;
  return {};
}

std::optional<int> ReplayedRig::CurrentStop() const {
  const std::lock_guard lock(mutex_);
  return current_stop_;
}

Result<CapturedPicture> ReplayedRig::PictureAt(int camera, int stop) const {
  const std::vector<RecordedView>& views = Content().views;
  const std::string& id = Content().cameras.at(camera).id;
  const auto view = std::ranges::find_if(views, [&](const RecordedView& candidate) {
    return candidate.camera == camera && candidate.stop == stop && candidate.subject == subject_;
  });
  if (view == views.end()) {
    return Fail(ErrorCode::kDevice, "camera '{}': the recording '{}' has no picture of it at stop '{}'", id,
                Content().id, Content().stops.at(stop).id);
  }
  Result<CapturedPicture> picture = pictures_.load(static_cast<int>(view - views.begin()));
  if (!picture) return Fail(ErrorCode::kDevice, "camera '{}': {}", id, picture.error().message);
  picture->exposure_us = view->exposure_us;
  picture->gain_db = view->gain_db;
  picture->taken_at = view->taken_at;
  return picture;
}

}  // namespace rigcal
