#include "core/base/clock.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <string>

#include "tests/support/fake_clock.h"

namespace rigcal {
namespace {

constexpr double kHour_s = 3600;  ///< a wait that only its stop token can end within the test
constexpr double kHang_s = 60;    ///< beyond it a wait that should have ended hangs

TEST(SystemClock, TimePassesByWhatWasWaitedFor) {
  SystemClock clock;
  constexpr double kWait_s = 0.02;
  const double begin_s = clock.NowS();
  EXPECT_TRUE(clock.Wait(kWait_s, {}));
  EXPECT_GE(clock.NowS() - begin_s, kWait_s);
}

TEST(SystemClock, ATokenThatIsSetEndsAWaitAtOnce) {
  SystemClock clock;
  std::stop_source stop;
  stop.request_stop();
  const double begin_s = clock.NowS();
  EXPECT_FALSE(clock.Wait(kHour_s, stop.get_token()));
  EXPECT_LT(clock.NowS() - begin_s, kHang_s);
}

TEST(SystemClock, ATokenThatBecomesSetEndsAWaitUnderWay) {
  SystemClock clock;
  std::stop_source stop;
  std::promise<void> waiting;
  auto waited = std::async(std::launch::async, [&] {
    waiting.set_value();
    return clock.Wait(kHour_s, stop.get_token());
  });
  waiting.get_future().wait();
  stop.request_stop();
  ASSERT_EQ(waited.wait_for(std::chrono::duration<double>(kHang_s)), std::future_status::ready);
  EXPECT_FALSE(waited.get());
}

TEST(SystemClock, NoTimeIsPassedAtOnce) {
  SystemClock clock;
  EXPECT_TRUE(clock.Wait(0, {}));
  EXPECT_TRUE(clock.Wait(-kHour_s, {}));
}

TEST(FakeClock, TimePassesByWaitingAlone) {
  FakeClock clock;
  EXPECT_EQ(clock.NowS(), 0);
  EXPECT_TRUE(clock.Wait(kHour_s, {}));
  EXPECT_EQ(clock.NowS(), kHour_s);
  EXPECT_TRUE(clock.Wait(-1, {}));
  EXPECT_EQ(clock.NowS(), kHour_s);
}

TEST(FakeClock, EventsHappenInTheirOrderAndTheTokenEndsTheWaitThen) {
  FakeClock clock;
  std::string order;
  clock.After(2, [&] { order += fmt::format("b{} ", clock.NowS()); });
  clock.After(1, [&] { order += fmt::format("a{} ", clock.NowS()); });
  const std::stop_token stop = clock.StopAfter(3);
  EXPECT_FALSE(clock.Wait(10, stop));
  EXPECT_EQ(order, "a1 b2 ");
  EXPECT_EQ(clock.NowS(), 3);
  EXPECT_FALSE(clock.Wait(10, stop));
  EXPECT_EQ(clock.NowS(), 3);
}

}  // namespace
}  // namespace rigcal
