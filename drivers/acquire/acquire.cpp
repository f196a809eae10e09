#include "drivers/acquire/acquire.h"

#include <algorithm>

#include "core/base/ensure.h"
#include "drivers/acquire/phase_timer.h"
#include "drivers/acquire/store_queue.h"
#include "drivers/acquire/take_pictures.h"

namespace rigcal {
namespace {

constexpr int kQueuedStops = 2;  ///< pictures of so many stops may wait for the disk: memory is bounded

/// Whatever ends the acquisition leaves the machine at rest.
class HaltAtEnd {
 public:
  explicit HaltAtEnd(PositionerDevice* positioner) : positioner_(positioner) {}
  HaltAtEnd(const HaltAtEnd&) = delete;
  HaltAtEnd& operator=(const HaltAtEnd&) = delete;
  ~HaltAtEnd() {
    if (positioner_ != nullptr) positioner_->Halt();
  }

 private:
  PositionerDevice* positioner_;
};

void CheckPlan(const AcquisitionDevices& devices, const AcquisitionPlan& plan) {
  Ensure(devices.clock != nullptr, "an acquisition needs a clock");
  Ensure(devices.positioner != nullptr || plan.stops.size() <= 1, "without a positioner there is one stop");
  Ensure(!plan.cameras_at || (devices.positioner != nullptr && plan.stops.empty()), "who says the stops is one");
  for (const PlannedStop& planned : plan.stops) {
    for (const int camera : planned.cameras) {
      Ensure(camera >= 0 && camera < static_cast<int>(devices.cameras.size()), "a planned camera exists");
    }
  }
}

Result<RecordedStop> GoTo(const AcquisitionDevices& devices, const StopTarget& target, const std::stop_token& token) {
  if (devices.positioner == nullptr) return RecordedStop{.id = target.id};
  return devices.positioner->MoveTo(target, token);
}

class Acquisition {
 public:
  Acquisition(const AcquisitionDevices& devices, const AcquisitionPlan& plan, StoreQueue& queue, PhaseTimer& timer)
      : devices_(devices), plan_(plan), queue_(queue), timer_(timer), taker_(devices, plan) {}

  Result<void> Run(const std::stop_token& token) {
    timer_.Enter(AcquisitionPhase::kMoving, 0);
    if (devices_.positioner != nullptr && (plan_.cameras_at || !plan_.stops.empty())) {
      if (Result<void> homed = devices_.positioner->Home(token); !homed) return homed;
    }
    return plan_.cameras_at ? TakeToldStops(token) : TakePlannedStops(token);
  }

  [[nodiscard]] const PictureTaker& Taker() const { return taker_; }

 private:
  Result<void> TakePlannedStops(const std::stop_token& token) {
    for (int s = 0; s < static_cast<int>(plan_.stops.size()); ++s) {
      timer_.Enter(AcquisitionPhase::kMoving, s);
      const Result<RecordedStop> reached = GoTo(devices_, plan_.stops[s].target, token);
      if (!reached) return Fail(reached.error());
      const Result<void> taken = TakePictures(s, *reached, plan_.stops[s].cameras, token);
      if (Result<void> finished = Finish(s, taken); !finished) return finished;
    }
    return {};
  }

  Result<void> TakeToldStops(const std::stop_token& token) {
    for (int s = 0;; ++s) {
      timer_.Enter(AcquisitionPhase::kMoving, s);
      const Result<std::optional<RecordedStop>> reached = devices_.positioner->NextStop(token);
      if (!reached) return Fail(reached.error());
      if (!*reached) return {};
      const Result<std::vector<int>> cameras = plan_.cameras_at(**reached);
      const Result<void> taken = cameras ? TakePictures(s, **reached, *cameras, token) : Fail(cameras.error());
      if (Result<void> finished = Finish(s, taken); !finished) return finished;
    }
  }

  Result<void> TakePictures(int s, const RecordedStop& reached, const std::vector<int>& cameras,
                            const std::stop_token& token) {
    if (cameras.empty()) return {};
    timer_.Enter(AcquisitionPhase::kSettling, s);
    if (!devices_.clock->Wait(plan_.settle_s, token)) {
      return Fail(ErrorCode::kCancelled, "the acquisition was stopped on request");
    }
    timer_.Enter(AcquisitionPhase::kTaking, s);
    const auto keep = [&](int camera, CapturedPicture picture) -> Result<void> {
      timer_.Enter(AcquisitionPhase::kStoring, s);
      Result<void> pushed = queue_.Push({camera, reached, std::move(picture)}, token);
      timer_.Enter(AcquisitionPhase::kTaking, s);
      return pushed;
    };
    return taker_.Take(reached.id, cameras, keep, token);
  }

  /// Tells whoever moves the positioner what came of the stop, and hands it on.
  Result<void> Finish(int s, const Result<void>& taken) {
    timer_.Enter(AcquisitionPhase::kMoving, s);
    if (devices_.positioner == nullptr) return taken;
    const Result<void> finished = devices_.positioner->FinishStop(taken);
    return taken ? finished : taken;
  }

  const AcquisitionDevices& devices_;
  const AcquisitionPlan& plan_;
  StoreQueue& queue_;
  PhaseTimer& timer_;
  PictureTaker taker_;
};

}  // namespace

std::string_view NameOf(AcquisitionPhase phase) {
  switch (phase) {
    case AcquisitionPhase::kMoving:
      return "moving";
    case AcquisitionPhase::kSettling:
      return "settling";
    case AcquisitionPhase::kTaking:
      return "taking";
    case AcquisitionPhase::kStoring:
      break;
  }
  return "waiting for the disk";
}

Result<AcquisitionOutcome> Acquire(const AcquisitionDevices& devices, const AcquisitionPlan& plan,
                                   const StorePicture& store,
                                   const std::function<void(const AcquisitionProgress&)>& listener,
                                   const std::stop_token& stop) {
  CheckPlan(devices, plan);
  const int num_cameras = static_cast<int>(devices.cameras.size());
  std::optional<int> num_stops;
  if (!plan.cameras_at) num_stops = static_cast<int>(plan.stops.size());
  StoreQueue queue(store, std::max(1, kQueuedStops * num_cameras));
  PhaseTimer timer(*devices.clock, num_stops, listener);
  Acquisition acquisition(devices, plan, queue, timer);
  const Result<void> taken = [&] {
    const HaltAtEnd halt(devices.positioner);
    return acquisition.Run(stop);
  }();
  timer.Enter(AcquisitionPhase::kStoring);
  const Result<void> stored = queue.Finish(stop);  // what was taken is kept, also when something failed afterwards
  if (!taken) return Fail(taken.error());
  if (!stored) return Fail(stored.error());
  return AcquisitionOutcome{.times = timer.Times(),
                            .num_pictures = queue.NumStored(),
                            .num_retaken = acquisition.Taker().NumRetaken(),
                            .num_recovered = acquisition.Taker().NumRecovered()};
}

}  // namespace rigcal
