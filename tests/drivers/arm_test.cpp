// The contract for positioners (positioner_contract.h) is that of machines that rigcal moves. An arm is moved by
// somebody else; what of it holds here as well is tested here under the same names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <list>
#include <stdexcept>

#include "drivers/arm/arm_driver.h"
#include "drivers/arm/pose_line.h"
#include "drivers/arm/programmed_arm.h"
#include "drivers/registry.h"
#include "tests/drivers/arm_program.h"

namespace rigcal {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

class ArmTest : public ::testing::Test {
 protected:
  ArmTest() { Listen(); }
  void Listen(double move_timeout_s = 60) {
    arm_.reset();
    settings_ = {.driver = "arm", .address = "127.0.0.1:0", .move_timeout_s = move_timeout_s};
    arm_ = std::move(*ProgrammedArm::Listen({.host = "127.0.0.1"}, settings_, clock_));
  }
  /// The program says something, and the arm is asked for its next stop.
  Result<std::optional<RecordedStop>> Next(Program& program, const std::string& text) {
    program.Say(text);
    return arm_->NextStop({});
  }
  /// The program is refused, and hears the same.
  void ExpectRefused(const std::string& text, const std::string& name, const std::string& why) {
    SCOPED_TRACE(text);
    Listen();
    Program program(arm_->Address());
    ASSERT_TRUE(Next(program, Pose("00")));
    ASSERT_TRUE(arm_->FinishStop({}));
    ASSERT_EQ(program.Hear(), "done 00");
    const auto next = Next(program, text);
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().code, ErrorCode::kDevice);
    EXPECT_THAT(next.error().message, StartsWith("arm: its program at 127.0.0.1:"));
    EXPECT_THAT(next.error().message, HasSubstr("after stop '00': "));
    EXPECT_THAT(next.error().message, HasSubstr(why));
    const std::string heard = program.Hear();
    EXPECT_THAT(heard, StartsWith("error " + name + " "));
    EXPECT_THAT(heard, HasSubstr(why));
  }

  PatientClock clock_;
  PositionerSettings settings_;
  std::unique_ptr<ProgrammedArm> arm_;
};

TEST_F(ArmTest, GoesWhereItsProgramSaysAndReportsIt) {
  Program program(arm_->Address());
  ASSERT_TRUE(program.Connected());
  ASSERT_TRUE(arm_->Home({}));
  for (const std::string id : {"near", "far.2"}) {
    const auto stop = Next(program, Pose(id, id == "near" ? 0.5 : 0.75));
    ASSERT_TRUE(stop) << MessageOf(stop);
    ASSERT_TRUE(*stop);
    EXPECT_EQ((*stop)->id, id);
    EXPECT_TRUE((*stop)->axes.empty());
    for (const auto& pose : {(*stop)->base_from_flange_commanded, (*stop)->base_from_flange_reported}) {
      ASSERT_TRUE(pose);
      EXPECT_TRUE(pose->translation.isApprox(Eigen::Vector3d(id == "near" ? 0.5 : 0.75, -0.25, 1.5)));
      EXPECT_TRUE(pose->rotation.isApprox(Eigen::Quaterniond(0.6, 0, 0.8, 0)));
    }
    ASSERT_TRUE(arm_->FinishStop({}));
    EXPECT_EQ(program.Hear(), "done " + id);
  }
  const auto end = Next(program, "end\n");
  ASSERT_TRUE(end) << MessageOf(end);
  EXPECT_FALSE(*end);
  EXPECT_FALSE(*arm_->NextStop({})) << "it stays at its end";
}

TEST_F(ArmTest, MoveToIsTheNextStopUnderItsOwnName) {
  Program program(arm_->Address());
  program.Say(Pose("K7"));
  const Result<RecordedStop> stop = arm_->MoveTo({"00", {}}, {});
  ASSERT_TRUE(stop) << MessageOf(stop);
  EXPECT_EQ(stop->id, "K7");
  ASSERT_TRUE(arm_->FinishStop({}));
  EXPECT_EQ(arm_->MoveTo({"01", {0.5}}, {}).error().code, ErrorCode::kBadInput);
  program.Say("end\n");
  const Result<RecordedStop> none = arm_->MoveTo({"01", {}}, {});
  EXPECT_THAT(MessageOf(none), HasSubstr("no further stop, '01' was expected"));
}

TEST_F(ArmTest, AStopThatFailedIsFinishedToo) {
  Program program(arm_->Address());
  ASSERT_TRUE(Next(program, Pose("00")));
  EXPECT_TRUE(arm_->FinishStop(Fail(ErrorCode::kDevice, "camera 'left'\r\nis\ngone")));
  EXPECT_EQ(program.Hear(), "error 00 camera 'left'  is gone");
  EXPECT_TRUE(Next(program, Pose("01")));
}

TEST_F(ArmTest, LinesMayComeInPiecesAndEndAsAnywhere) {
  Program program(arm_->Address());
  program.Say("\r\npose 00 0.");
  clock_.Fake().After(1, [&] { program.Say("5 -.25 +1.5 1e0 0 0 0\r\n"); });
  const auto stop = arm_->NextStop({});
  ASSERT_TRUE(stop) << MessageOf(stop);
  EXPECT_EQ((*stop)->id, "00");
  EXPECT_EQ((*stop)->base_from_flange_reported->translation, Eigen::Vector3d(0.5, -0.25, 1.5));
}

TEST_F(ArmTest, ClosingInGoodOrderAfterAnAnswerIsTheEnd) {
  Program program(arm_->Address());
  ASSERT_TRUE(Next(program, Pose("00")));
  ASSERT_TRUE(arm_->FinishStop({}));
  ASSERT_EQ(program.Hear(), "done 00");
  program.Close();
  const auto end = arm_->NextStop({});
  ASSERT_TRUE(end) << MessageOf(end);
  EXPECT_FALSE(*end);
}

TEST_F(ArmTest, TheEndMayBeSaidBeforeTheLastAnswer) {
  Program program(arm_->Address());
  ASSERT_TRUE(Next(program, Pose("00") + "end\n"));
  program.SayNoMore();
  const Result<void> finished = arm_->FinishStop({});
  EXPECT_TRUE(finished) << MessageOf(finished);
  EXPECT_EQ(program.Hear(), "done 00");
  EXPECT_FALSE(*arm_->NextStop({}));
}

TEST_F(ArmTest, RefusesWhatIsNoPose) {
  ExpectRefused("hello\n", "-", "'hello' is neither 'pose K x y z qw qx qy qz' nor 'end'");
  ExpectRefused("pose\n", "-", "8 words, not 0");
  ExpectRefused("pose 01 0 0 0 1 0 0\n", "01", "8 words, not 7");
  ExpectRefused("pose 01 0 0 0 1 0 0 0 0\n", "01", "8 words, not 9");
  ExpectRefused("pose 01 0 0,5 0 1 0 0 0\n", "01", "the y of pose '01' is '0,5', which is not a number");
  ExpectRefused("pose 01 0 0 nan 1 0 0 0\n", "01", "the z of pose '01' is 'nan'");
  ExpectRefused("pose 01 0 0 0 inf 0 0 0\n", "01", "the qw of pose '01' is 'inf'");
  ExpectRefused("pose 01 350 0 0 1 0 0 0\n", "01", "the x of pose '01' is 350 m, the limit is 20 m");
}

TEST_F(ArmTest, RefusesAQuaternionThatIsNotUnit) {
  ExpectRefused("pose 01 0 0 0 0.6 0 0.8 0.1\n", "01", "has the length 1.004988, 1 +- 0.001 is allowed");
  ExpectRefused("pose 01 0 0 0 0 0 0 0\n", "01", "has the length 0.000000");
  const Result<RecordedStop> rounded = ParsePose("01 0 0 0 0.7071 0 0.7071 0");
  ASSERT_TRUE(rounded) << MessageOf(rounded);
  EXPECT_NEAR(rounded->base_from_flange_reported->rotation.norm(), 1, 1e-15);
}

TEST_F(ArmTest, RefusesAPoseTwice) {
  ExpectRefused(Pose("00"), "00", "the stop '00' was there already");
}

TEST_F(ArmTest, RefusesANameThatFilesCannotHold) {
  ExpectRefused(Pose("../x"), "-", "'../x' cannot be the name of a stop");
  ExpectRefused(Pose(std::string(65, 'k')), "-", "at most 64 letters, digits, '.', '_' and '-'");
  EXPECT_TRUE(ParsePose("A-b_3." + std::string(58, 'k') + " 0 0 0 1 0 0 0"));
}

TEST_F(ArmTest, RefusesALineThatDoesNotEnd) {
  ExpectRefused("pose 01 " + std::string(600, '1'), "-", "a line has at most 512 bytes");
  ExpectRefused("pose 01 " + std::string(600, '1') + "\n", "-", "a line has at most 512 bytes");
  ExpectRefused("pose 01 0 0 0 1 0 0 0" + std::string(600, ' ') + "\n", "-", "a line has at most 512 bytes");
  Listen();
  Program program(arm_->Address());
  const std::string pose = "pose 01 0 0 0 1 0 0 0";
  EXPECT_TRUE(Next(program, pose + std::string(512 - pose.size(), ' ') + "\r\n"));
}

TEST_F(ArmTest, RefusesPosesThatDoNotWaitForTheAnswer) {
  Program program(arm_->Address());
  const auto next = Next(program, Pose("00") + "\r\n" + Pose("01"));
  ASSERT_FALSE(next);
  EXPECT_THAT(program.Hear(), StartsWith("error 00 the next pose came before the answer to '00'"));
  Listen();
  Program later(arm_->Address());
  ASSERT_TRUE(Next(later, Pose("00")));
  later.Say(Pose("01"));
  const Result<void> finished = arm_->FinishStop({});
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::kDevice);
  EXPECT_THAT(finished.error().message, HasSubstr("must be taken anew"));
  EXPECT_THAT(later.Hear(), StartsWith("error 00 "));
}

TEST_F(ArmTest, ASecondProgramIsRefusedAndTheFirstGoesOn) {
  Program first(arm_->Address());
  ASSERT_TRUE(Next(first, Pose("00")));
  Program second(arm_->Address());
  second.Say(Pose("01"));
  ASSERT_TRUE(arm_->FinishStop({}));
  EXPECT_EQ(first.Hear(), "done 00");
  clock_.Fake().After(1, [&] { first.Say(Pose("02")); });
  const auto next = arm_->NextStop({});
  ASSERT_TRUE(next) << MessageOf(next);
  EXPECT_EQ((*next)->id, "02");
  EXPECT_EQ(second.Hear(), "error - another program moves the arm already, this connection is closed");
  EXPECT_EQ(second.Hear(), "closed");
  EXPECT_TRUE(arm_->FinishStop({}));
  EXPECT_EQ(first.Hear(), "done 02");
}

TEST_F(ArmTest, AScannerIsNotTakenForTheProgram) {
  Program silent(arm_->Address()), closing(arm_->Address()), web(arm_->Address()), breaking(arm_->Address());
  Program ending(arm_->Address());
  closing.Close();
  web.Say("GET / HTTP/1.0\r\n\r\n");
  breaking.Break();
  ending.Say("end\n");
  std::optional<Program> program;
  clock_.Fake().After(1, [&] {
    program.emplace(arm_->Address());
    program->Say(Pose("00"));
  });
  const auto next = arm_->NextStop({});
  ASSERT_TRUE(next) << MessageOf(next);
  EXPECT_EQ((*next)->id, "00");
  EXPECT_THAT(web.Hear(), StartsWith("error - 'GET / HTTP/1.0' is neither"));
  EXPECT_EQ(ending.Hear(), "error - 'end' came before the first pose");
  EXPECT_THAT(silent.Hear(), HasSubstr("another program moves the arm"));
  EXPECT_EQ(silent.Hear(), "closed");
}

TEST_F(ArmTest, ManyWhoSayNothingDoNotKeepTheProgramOut) {
  std::list<Program> silent;
  for (int i = 0; i < 20; ++i) {
    silent.emplace_back(arm_->Address());
    EXPECT_EQ(arm_->NextStop(clock_.Fake().StopAfter(0.05)).error().code, ErrorCode::kCancelled);
  }
  Program program(arm_->Address());
  EXPECT_TRUE(Next(program, Pose("00")));
  EXPECT_EQ(silent.front().Hear(), "closed") << "the first of too many has to go";
  EXPECT_THAT(silent.back().Hear(), HasSubstr("another program"));
}

TEST_F(ArmTest, AMoveThatGetsNowhereEndsInTime) {
  Listen(10);
  const auto nobody = arm_->NextStop({});
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(nobody.error().message,
            fmt::format("arm: no program has sent a pose to {} within 10.0 s", ToText(arm_->Address())));
  Program program(arm_->Address());
  ASSERT_TRUE(Next(program, Pose("00")));
  ASSERT_TRUE(arm_->FinishStop({}));
  const double begin_s = clock_.NowS();
  const auto silent = arm_->NextStop({});
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(silent.error().message, "arm: no pose after stop '00' within 10.0 s");
  EXPECT_NEAR(clock_.NowS() - begin_s, 10, 0.1);
  EXPECT_EQ(program.Hear(), "done 00");
  EXPECT_EQ(program.Hear(), "error - no pose within 10.0 s");
}

TEST_F(ArmTest, ALostConnectionIsReported) {
  Program gone(arm_->Address());
  ASSERT_TRUE(Next(gone, Pose("00")));
  gone.Close();
  const Result<void> finished = arm_->FinishStop({});
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::kDevice);
  EXPECT_THAT(finished.error().message, EndsWith("went away before the answer to stop '00'"));
  Listen();
  Program program(arm_->Address());
  ASSERT_TRUE(Next(program, Pose("00")));
  ASSERT_TRUE(arm_->FinishStop({}));
  clock_.Fake().After(0.5, [&] { program.Break(); });
  const auto broken = arm_->NextStop({});
  EXPECT_THAT(MessageOf(broken),
              MatchesRegex("arm: the connection to its program at 127.0.0.1:[0-9]+ is lost after stop '00'"));
  Listen();
  Program half(arm_->Address());
  ASSERT_TRUE(Next(half, Pose("00")));
  ASSERT_TRUE(arm_->FinishStop({}));
  half.Say("pose 01 0 0");
  half.SayNoMore();
  EXPECT_THAT(MessageOf(arm_->NextStop({})), EndsWith("after stop '00', in the middle of a line"));
}

TEST_F(ArmTest, AStopTokenHaltsIt) {
  Program program(arm_->Address());
  ASSERT_TRUE(Next(program, Pose("00")));
  ASSERT_TRUE(arm_->FinishStop({}));
  EXPECT_EQ(program.Hear(), "done 00");
  const auto cancelled = arm_->NextStop(clock_.Fake().StopAfter(0.5));
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, ErrorCode::kCancelled);
  EXPECT_NEAR(clock_.NowS(), 0.5, 0.1);
  EXPECT_EQ(program.Hear(), "error - the capture was stopped on request");
  std::stop_source set;
  set.request_stop();
  EXPECT_EQ(arm_->Home(set.get_token()).error().code, ErrorCode::kCancelled);
  program.Say(Pose("01"));
  EXPECT_EQ(arm_->NextStop(set.get_token()).error().code, ErrorCode::kCancelled);
}

TEST_F(ArmTest, AnExceptionAHaltAndDestructionAnswerTheProgram) {
  Program program(arm_->Address());
  clock_.Fake().After(0.5, [] { throw std::runtime_error("in the middle of a wait"); });
  EXPECT_ANY_THROW((void)arm_->NextStop({}));
  ASSERT_TRUE(Next(program, Pose("00")));
  arm_->Halt();
  arm_->Halt();  // safe at any time
  EXPECT_EQ(program.Hear(), "error 00 the capture ended before its pictures were taken");
  ASSERT_TRUE(arm_->FinishStop({})) << "it has its answer";
  program.Say("what nobody reads any more\n");
  arm_.reset();
  EXPECT_EQ(program.Hear(), "closed");
}

TEST_F(ArmTest, APortInUseIsNamed) {
  const auto second = ProgrammedArm::Listen(arm_->Address(), settings_, clock_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kDevice);
  EXPECT_EQ(second.error().message,
            fmt::format("arm: cannot listen on {}: the port is in use by another program", ToText(arm_->Address())));
  EXPECT_THAT(MessageOf(ProgrammedArm::Listen({.host = "studio.invalid"}, settings_, clock_)),
              HasSubstr("cannot listen on studio.invalid:0: the host must be an address"));
  EXPECT_THAT(MessageOf(ProgrammedArm::Listen({.host = "192.0.2.1"}, settings_, clock_)),
              HasSubstr("cannot listen on 192.0.2.1:0: "));
}

TEST_F(ArmTest, ThePortOfACaptureThatHasEndedIsFree) {
  const SocketAddress address = arm_->Address();
  Program program(address);
  ASSERT_TRUE(Next(program, Pose("00")));
  arm_.reset();
  EXPECT_TRUE(ProgrammedArm::Listen(address, settings_, clock_));
}

TEST_F(ArmTest, ListensOnIpv6) {
  auto listening = ProgrammedArm::Listen({.host = "::1"}, settings_, clock_);
  if (!listening) GTEST_SKIP() << "no IPv6 here: " << listening.error().message;
  arm_ = std::move(*listening);
  Program program(arm_->Address());
  EXPECT_TRUE(Next(program, Pose("00")));
}

TEST_F(ArmTest, TheRegistryOpensItAndSaysWhereItListens) {
  std::string told;
  DriverContext context{.clock = &clock_, .tell = [&](const std::string& sentence) { told = sentence; }};
  RigHardware rig{.positioner = settings_};
  const Result<OpenedRig> opened = OpenRig(rig, context, {});
  ASSERT_TRUE(opened) << MessageOf(opened);
  EXPECT_TRUE(opened->real);
  EXPECT_THAT(told, MatchesRegex("arm: waits for its program on 127.0.0.1:[1-9][0-9]*"));
  rig.cameras = {{.id = "left", .driver = "arm"}};
  EXPECT_THAT(MessageOf(OpenRig(rig, context, {})), HasSubstr("the driver arm has no cameras"));
}

}  // namespace
}  // namespace rigcal
