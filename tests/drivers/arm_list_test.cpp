#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/arm/listed_arm.h"
#include "tests/config/temporary_folder.h"
#include "tests/drivers/arm_program.h"
#include "tests/support/fake_clock.h"

namespace rigcal {
namespace {

/// Poses that a file lists.
class ArmList : public ::testing::Test {
 protected:
  Result<std::unique_ptr<PositionerDevice>> Open(const std::string& text) {
    return OpenFile(folder_.Write("poses.txt", text).string());
  }
  Result<std::unique_ptr<PositionerDevice>> OpenFile(const std::string& file) {
    return ListedArm::Open({.driver = "arm", .address = file, .move_timeout_s = 30}, context_);
  }

  TemporaryFolder folder_;
  FakeClock clock_;
  DriverContext context_{.clock = &clock_};
};

constexpr const char* kList =
    "# the ring\n\n00 0.5 0 1 1 0 0 0\n  01 0.25 0 1 0 1 0 0  # over the head\r\n02 0 0 1 0 0 0 1";

TEST_F(ArmList, GivesItsStopsInOrder) {
  const auto arm = Open(kList);
  ASSERT_TRUE(arm) << MessageOf(arm);
  for (const std::string id : {"00", "01", "02"}) {
    const auto stop = (*arm)->NextStop({});
    ASSERT_TRUE(stop && *stop);
    EXPECT_EQ((*stop)->id, id);
    EXPECT_TRUE((*arm)->FinishStop({}));
  }
  EXPECT_FALSE(*(*arm)->NextStop({}));
}

TEST_F(ArmList, WhoMovesItByHandSaysThatItIsThere) {
  std::vector<std::string> asked;
  bool answers = true;
  context_.confirm = [&](const std::string& what, double timeout_s, const std::stop_token&) -> Result<void> {
    asked.push_back(fmt::format("{} within {} s", what, timeout_s));
    if (!answers) return Fail(ErrorCode::kTimeout, "nobody answers");
    return {};
  };
  const auto arm = Open(kList);
  ASSERT_TRUE((*arm)->NextStop({}));
  answers = false;
  EXPECT_EQ((*arm)->NextStop({}).error().code, ErrorCode::kTimeout);
  answers = true;
  EXPECT_EQ((**(*arm)->NextStop({})).id, "01") << "a stop that was not reached is still the next one";
  EXPECT_THAT(asked, ::testing::ElementsAre("arm: bring it to stop '00' (1 of 3) within 30 s",
                                            "arm: bring it to stop '01' (2 of 3) within 30 s",
                                            "arm: bring it to stop '01' (2 of 3) within 30 s"));
}

TEST_F(ArmList, AStopTokenEndsIt) {
  const auto arm = Open(kList);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ((*arm)->NextStop(stop.get_token()).error().code, ErrorCode::kCancelled);
}

TEST_F(ArmList, RefusesAFileThatIsNotAListOfPoses) {
  const std::string file = (folder_.Path() / "poses.txt").string();
  EXPECT_EQ(MessageOf(Open("00 0 0 0 1 0 0 0\n\n01 0 0 0 1 0 0\n")),
            "arm: " + file + " line 3: a pose is K x y z qw qx qy qz, 8 words, not 7");
  EXPECT_EQ(MessageOf(Open("00 0 0 0 1 0 0 0\n00 0 0 1 1 0 0 0\n")),
            "arm: " + file + " line 2: the stop '00' is in line 1 already");
  EXPECT_EQ(MessageOf(Open("# nothing\n")), "arm: " + file + ": has no pose");
  EXPECT_EQ(MessageOf(OpenFile("nowhere.txt")),
            "arm: nowhere.txt is neither HOST:PORT to listen on nor a file of poses");
  EXPECT_EQ(OpenFile(folder_.Path().string()).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace rigcal
