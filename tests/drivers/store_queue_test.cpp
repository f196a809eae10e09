#include "drivers/acquire/store_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr auto kHang = std::chrono::seconds(60);

TakenPicture Numbered(int number) {
  return {.camera = number};
}

/// A disk that takes pictures only once it is let go.
class Disk {
 public:
  Result<void> Store(const TakenPicture& taken) {
    std::unique_lock lock(mutex_);
    begun_ = true;
    changed_.notify_all();
    EXPECT_TRUE(changed_.wait_for(lock, kHang, [&] { return open_; }));
    stored.push_back(taken.camera);
    return {};
  }
  void AwaitBegin() {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, kHang, [&] { return begun_; }));
  }
  void Open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  std::vector<int> stored;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool begun_ = false, open_ = false;
};

/// Two pictures wait behind one that is being stored.
void Fill(StoreQueue& queue, Disk& disk) {
  ASSERT_TRUE(queue.Push(Numbered(0), {}));
  disk.AwaitBegin();
  ASSERT_TRUE(queue.Push(Numbered(1), {}));
  ASSERT_TRUE(queue.Push(Numbered(2), {}));
}

TEST(StoreQueue, StoresInOrder) {
  Disk disk;
  disk.Open();
  StoreQueue queue([&](const TakenPicture& taken) { return disk.Store(taken); }, 2);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(queue.Push(Numbered(i), {}));
  ASSERT_TRUE(queue.Finish({}));
  EXPECT_EQ(queue.NumStored(), 20);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(disk.stored.at(i), i);
}

TEST(StoreQueue, ADiskThatTakesNothingIsReported) {
  Disk disk;
  StoreQueue queue([&](const TakenPicture& taken) { return disk.Store(taken); }, 2, 0.05);
  Fill(queue, disk);
  const Result<void> fourth = queue.Push(Numbered(3), {});
  ASSERT_FALSE(fourth);
  EXPECT_EQ(fourth.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(fourth.error().message, HasSubstr("the disk has taken none"));
  EXPECT_EQ(queue.Finish({}).error().code, ErrorCode::kTimeout);
  disk.Open();
}

TEST(StoreQueue, AStopTokenEndsAWaitForRoom) {
  Disk disk;
  StoreQueue queue([&](const TakenPicture& taken) { return disk.Store(taken); }, 2);
  Fill(queue, disk);
  std::stop_source stop;
  auto fourth = std::async(std::launch::async, [&] { return queue.Push(Numbered(3), stop.get_token()); });
  stop.request_stop();
  ASSERT_EQ(fourth.wait_for(kHang), std::future_status::ready);
  EXPECT_EQ(fourth.get().error().code, ErrorCode::kCancelled);
  disk.Open();
}

TEST(StoreQueue, WhatWaitsIsDroppedAtTheEnd) {
  constexpr std::size_t kTries = 100;  // whether the disk opens before the end begins is left to chance
  std::size_t num_stored = 0;
  for (std::size_t i = 0; i < kTries; ++i) {
    Disk disk;
    std::future<void> opened;
    {
      StoreQueue queue([&](const TakenPicture& taken) { return disk.Store(taken); }, 2);
      Fill(queue, disk);
      opened = std::async(std::launch::async, [&] { disk.Open(); });
    }
    ASSERT_EQ(disk.stored.at(0), 0) << "what is being stored is stored";
    num_stored += disk.stored.size();
  }
  EXPECT_LT(num_stored, 3 * kTries);
}

TEST(StoreQueue, TheFirstFailureIsEverybodys) {
  StoreQueue queue(
      [&](const TakenPicture& taken) -> Result<void> {
        if (taken.camera == 1) return Fail(ErrorCode::kDiskFull, "full");
        return {};
      },
      5);
  ASSERT_TRUE(queue.Push(Numbered(0), {}));
  ASSERT_TRUE(queue.Push(Numbered(1), {}));
  EXPECT_EQ(queue.Finish({}).error().code, ErrorCode::kDiskFull);
  EXPECT_EQ(queue.Push(Numbered(2), {}).error().code, ErrorCode::kDiskFull);
  EXPECT_EQ(queue.NumStored(), 1);
}

}  // namespace
}  // namespace rigcal
