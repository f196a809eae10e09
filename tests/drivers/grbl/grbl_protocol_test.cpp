#include "drivers/grbl/grbl_protocol.h"

#include <gmock/gmock.h>

#include <numbers>
#include <random>

#include "drivers/grbl/jog_path.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;

TEST(GrblProtocol, ReadsAReportWithTheWorkOffset) {
  const GrblLine line = ParseGrblLine("<Jog|MPos:1.000,-10.250,5.000|Bf:14,128|FS:500,0|Pn:XD|WCO:0.000,1.551,5.664>");
  ASSERT_EQ(line.kind, GrblLineKind::kStatus);
  EXPECT_EQ(line.status.state, GrblState::kJog);
  EXPECT_FALSE(line.status.AtRest());
  EXPECT_THAT(line.status.in_machine.value(), ElementsAre(1, -10.25, 5));
  EXPECT_THAT(line.status.work_in_machine.value(), ElementsAre(0, 1.551, 5.664));
  EXPECT_FALSE(line.status.in_work);
  EXPECT_EQ(line.status.pins, "XD");
}

TEST(GrblProtocol, ReadsAReportInWorkCoordinatesOfMoreAxes) {
  const GrblLine line = ParseGrblLine("<Hold:0|WPos:-2.500,0.000,11.000,7.000|Ov:100,100,100>");
  ASSERT_EQ(line.kind, GrblLineKind::kStatus);
  EXPECT_TRUE(line.status.AtRest());
  EXPECT_THAT(line.status.in_work.value(), ElementsAre(-2.5, 0, 11));
  EXPECT_FALSE(line.status.in_machine || line.status.work_in_machine);
}

TEST(GrblProtocol, KnowsWhichStatesRest) {
  const auto rests = [](const std::string& state) {
    return ParseGrblLine("<" + state + "|MPos:0,0,0>").status.AtRest();
  };
  for (const char* state : {"Idle", "Alarm", "Hold:0", "Door:0", "Door:1", "Check", "Sleep"}) EXPECT_TRUE(rests(state));
  for (const char* state : {"Run", "Jog", "Home", "Hold:1", "Door:2", "Door:3"}) EXPECT_FALSE(rests(state)) << state;
}

TEST(GrblProtocol, TakesWhatIsNoReportForNone) {
  for (const char* text : {"<Idle|MPos:0.000,0.000", "<Idle>", "<Idle|MPos:0,0>", "<Idle|MPos:a,b,c>",
                           "<Idle|MPos:nan,0,0>", "<Lost|MPos:0,0,0>", "<Idle|MPos:0,0,0|WCO:1,x,2>", "<>", "<", "",
                           "\x01\xff", "Id", "$", "$x=1", "okay", "[MSG:Check Door]"}) {
    EXPECT_EQ(ParseGrblLine(text).kind, GrblLineKind::kOther) << text;
  }
}

TEST(GrblProtocol, ReadsRepliesAlarmsBannersAndSettings) {
  EXPECT_EQ(ParseGrblLine("ok").kind, GrblLineKind::kOk);
  EXPECT_EQ(ParseGrblLine("error:15").number, 15);
  EXPECT_EQ(ParseGrblLine("error: Bad number").kind, GrblLineKind::kError);
  EXPECT_EQ(ParseGrblLine("ALARM:9").number, 9);
  EXPECT_EQ(ParseGrblLine("Grbl 1.1h ['$' for help]").text, "1.1h");
  EXPECT_EQ(ParseGrblLine("GrblHAL 1.1f ['$' or '$HELP' for help]").kind, GrblLineKind::kBanner);
  const GrblLine setting = ParseGrblLine("$110=1800.000");
  EXPECT_EQ(setting.kind, GrblLineKind::kSetting);
  EXPECT_EQ(setting.number, 110);
  EXPECT_EQ(setting.text, "1800.000");
}

TEST(GrblProtocol, LinesAreTheSameWhereverTheReadsCutThem) {
  const std::string text = "\r\nGrbl 1.1h ['$' for help]\r\nok\r\n<Idle|MPos:0,0,0>\n\n";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    LineSplitter splitter;
    splitter.Add(text.substr(0, cut));
    splitter.Add(text.substr(cut));
    EXPECT_EQ(splitter.Next(), "Grbl 1.1h ['$' for help]");
    EXPECT_EQ(splitter.Next(), "ok");
    EXPECT_EQ(splitter.Next(), "<Idle|MPos:0,0,0>");
    EXPECT_FALSE(splitter.Next());
  }
}

TEST(GrblProtocol, ALineThatDoesNotEndIsDroppedWhole) {
  LineSplitter splitter;
  for (int i = 0; i < 10000; ++i) splitter.Add("ok ALARM:1 garbage ");
  EXPECT_FALSE(splitter.Next());
  splitter.Add("ok\nok\n");
  EXPECT_EQ(splitter.Next(), "ok");
  EXPECT_FALSE(splitter.Next());
}

TEST(GrblProtocol, NoBytesBreakIt) {
  std::mt19937 random(7);
  const std::string alphabet = "<>|:,.0123456789-MPosWCOIdleJogALARM$=\r\n\xff";
  LineSplitter splitter;
  for (int i = 0; i < 100000; ++i) splitter.Add(std::string(1, alphabet[random() % alphabet.size()]));
  int lines = 0;
  while (const auto line = splitter.Next()) {
    (void)ParseGrblLine(*line);
    ++lines;
  }
  EXPECT_GT(lines, 100);
}

TEST(JogPath, AMetreIsAThousandAndATurnThreeHundredAndSixty) {
  EXPECT_DOUBLE_EQ(GrblFromAxis(0.25, AxisUnit::kMetre), 250);
  EXPECT_DOUBLE_EQ(GrblFromAxis(std::numbers::pi, AxisUnit::kRadian), 180);
  EXPECT_DOUBLE_EQ(AxisFromGrbl(250, AxisUnit::kMetre), 0.25);
  EXPECT_DOUBLE_EQ(AxisFromGrbl(180, AxisUnit::kRadian), std::numbers::pi);
}

constexpr GrblMachine kMachine{.max_rate_per_min = {6000, 6000, 6000}, .max_acceleration_per_s2 = {100, 100, 100}};

TEST(JogPath, NeverHoldsMoreThanItsLead) {
  JogPath path({0, 0, 0}, {100, 0, 0}, {0}, {10}, kMachine);
  GrblPosition at{};
  std::string last;
  const double lead = 10 * JogPath::kLead_s + 10 * 10 / (2 * 100.0), segment = 10 * JogPath::kSegment_s;
  for (; at[0] < 100; at[0] += 0.5) {
    int sent = 0;
    for (std::string jog = path.NextJog(at); !jog.empty(); jog = path.NextJog(at)) {
      last = jog;
      ASSERT_LE(std::stod(jog.substr(jog.find('X') + 1)), at[0] + lead + 1.5 * segment);
      ASSERT_LE(++sent, JogPath::kMostQueued);
    }
  }
  EXPECT_TRUE(path.AllSent());
  EXPECT_EQ(last, "$J=G90G21X100.0000F600.000");
}

TEST(JogPath, NoAxisIsFasterThanItsSpeed) {
  JogPath path({0, 0, 0}, {3, 4, 0}, {0, 1}, {1, 10}, kMachine);
  const std::string jog = path.NextJog({});
  const double feed_per_s = std::stod(jog.substr(jog.find('F') + 1)) / 60;
  EXPECT_NEAR(feed_per_s * 3 / 5, 1, 1e-5);  // X at its own speed, Y slower than it may
}

TEST(JogPath, NoWayIsNoJog) {
  JogPath path({5, 0, 0}, {5, 0, 0}, {0}, {1}, kMachine);
  EXPECT_TRUE(path.AllSent());
  EXPECT_EQ(path.NextJog({5, 0, 0}), "");
}

}  // namespace
}  // namespace rigcal
