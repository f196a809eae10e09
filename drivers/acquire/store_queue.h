#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "drivers/acquire/acquire.h"

namespace rigcal {

/// Pictures on their way to the disk, at most `capacity`, and the thread that stores them. Waits here are for another
/// thread, not for time: they take the machine's own clock and end at the latest when the disk has taken no picture for
/// kStuckDisk_s.
class StoreQueue {
 public:
  static constexpr double kStuckDisk_s = 60;  ///< far above what a slow disk needs for a picture

  StoreQueue(StorePicture store, int capacity, double stuck_s = kStuckDisk_s);
  StoreQueue(const StoreQueue&) = delete;
  StoreQueue& operator=(const StoreQueue&) = delete;
  /// Drops what waits, and returns when the picture that is being stored is.
  ~StoreQueue();

  /// Waits for room. Errors: the store's, of an earlier picture; kTimeout; kCancelled. What the store throws is thrown
  /// here.
  Result<void> Push(TakenPicture picture, const std::stop_token& stop);
  /// Waits until all are stored. Errors: those of Push.
  Result<void> Finish(const std::stop_token& stop);

  [[nodiscard]] int NumStored() const;

 private:
  void Run(const std::stop_token& stop);
  /// Waits for `ready`, or the first failure.
  template <typename Condition>
  Result<void> Await(std::unique_lock<std::mutex>& lock, const std::stop_token& stop, const Condition& ready);

  const StorePicture store_;
  const std::size_t capacity_;
  const double stuck_s_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<TakenPicture> waiting_;
  bool storing_ = false;
  int num_stored_ = 0;
  std::optional<Error> failure_;
  std::exception_ptr thrown_;
  std::jthread writer_;  ///< the last member: it uses the others
};

}  // namespace rigcal
