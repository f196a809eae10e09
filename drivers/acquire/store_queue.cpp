#include "drivers/acquire/store_queue.h"

#include <chrono>
#include <utility>

namespace rigcal {

StoreQueue::StoreQueue(StorePicture store, int capacity, double stuck_s)
    : store_(std::move(store)), capacity_(static_cast<std::size_t>(capacity)), stuck_s_(stuck_s) {
  writer_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

StoreQueue::~StoreQueue() {
  writer_.request_stop();
  writer_.join();
}

void StoreQueue::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !waiting_.empty(); }) && !stop.stop_requested()) {
    const TakenPicture picture = std::move(waiting_.front());
    waiting_.pop_front();
    storing_ = true;
    lock.unlock();
    Result<void> stored;
    std::exception_ptr thrown;
    try {
      stored = store_(picture);
    } catch (...) {
      thrown = std::current_exception();
    }
    lock.lock();
    storing_ = false;
    thrown_ = thrown;
    if (!stored) failure_ = stored.error();
    const bool good = stored && !thrown;
    if (good) ++num_stored_;
    changed_.notify_all();
    if (!good) return;
  }
}

template <typename Condition>
Result<void> StoreQueue::Await(std::unique_lock<std::mutex>& lock, const std::stop_token& stop,
                               const Condition& ready) {
  const auto over = [&] { return failure_ || thrown_ || ready(); };
  const auto limit = std::chrono::duration<double>(stuck_s_);
  int num_stored = num_stored_;
  while (!changed_.wait_for(lock, stop, limit, over) && !stop.stop_requested()) {
    if (num_stored == num_stored_) {
      return Fail(ErrorCode::kTimeout, "storing pictures: the disk has taken none for {:.0f} s, {} wait", stuck_s_,
                  waiting_.size());
    }
    num_stored = num_stored_;
  }
  if (thrown_) std::rethrow_exception(thrown_);
  if (failure_) return Fail(*failure_);
  if (!ready()) return Fail(ErrorCode::kCancelled, "storing pictures was stopped on request");
  return {};
}

Result<void> StoreQueue::Push(TakenPicture picture, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  Result<void> room = Await(lock, stop, [&] { return waiting_.size() < capacity_; });
  if (!room) return room;
  waiting_.push_back(std::move(picture));
  changed_.notify_all();
  return {};
}

Result<void> StoreQueue::Finish(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  return Await(lock, stop, [&] { return waiting_.empty() && !storing_; });
}

int StoreQueue::NumStored() const {
  const std::lock_guard lock(mutex_);
  return num_stored_;
}

}  // namespace rigcal
