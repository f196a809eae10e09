#include "config/result_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "config/recording_file.h"
#include "config/run_report.h"
#include "config/seed_report.h"
#include "config/store/sqlite_store.h"
#include "tests/config/example_recording.h"
#include "tests/config/example_revision.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(ReportedVerdict, IsThatOfARunsReport) {
  RunReport report;
  for (const Verdict verdict : {Verdict::kAccepted, Verdict::kRejected, Verdict::kInconclusive}) {
    report.validation.verdict = verdict;
    const auto reported = ParseReportedVerdict(ReportText(report), "report.json");
    ASSERT_TRUE(reported) << reported.error().message;
    EXPECT_EQ(reported->verdict, verdict);
    EXPECT_THAT(reported->reasons, IsEmpty());
  }
  report.validation.reasons = {{"epipolar", 1.3, 1, "px", "a.png"},
                               {"holdout", std::numeric_limits<double>::quiet_NaN(), 1, "px"}};
  EXPECT_THAT(ParseReportedVerdict(ReportText(report), "report.json")->reasons,
              ElementsAre(ReasonText(report.validation.reasons[0]), ReasonText(report.validation.reasons[1])));
}

TEST(ReportedVerdict, OfASeedIsWhetherItContradictsItself) {
  SeedResult seed;
  const auto reported = [&seed] { return *ParseReportedVerdict(SeedReportText({}, {}, seed), "report.json"); };
  EXPECT_EQ(reported().verdict, Verdict::kAccepted);
  seed.report.contradictions = {"stop '03' contradicts the rig"};
  EXPECT_EQ(reported().verdict, Verdict::kInconclusive);
  EXPECT_THAT(reported().reasons, ElementsAre("stop '03' contradicts the rig"));
}

TEST(ReportedVerdict, OtherTextsAreRefused) {
  for (const char* text : {"", "{", "[]", "{}", R"({"format": 3})", R"({"format": "rigcal report", "version": 2})",
                           R"({"format": "rigcal report", "version": 1, "verdict": "fine", "reasons": []})",
                           R"({"format": "rigcal report", "version": 1, "verdict": "accepted", "reasons": {}})",
                           R"({"format": "rigcal seed report", "version": 1, "contradictions": [1]})"}) {
    const auto reported = ParseReportedVerdict(text, "report.json");
    ASSERT_FALSE(reported) << text;
    EXPECT_THAT(reported.error().message, HasSubstr("report.json")) << text;
  }
}

class ResultFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    store_ = std::move(*OpenSqliteStore(folder_.Path() / kStoreFile, {.create = true}));
    const std::string recording = RecordingText(ExampleRecording());
    folder_.Write("recording/recording.json", recording);
    given_ = ExampleRevision("studio", 1, Verdict::kRejected);
    given_.head.origin.run.inputs = {{"recording.json", Sha256Hex(recording)}};
    RunReport report;
    report.validation.verdict = Verdict::kRejected;
    report.validation.reasons = {{"epipolar", 1.3, 1, "px"}};
    given_.report_text = ReportText(report);
  }

  Result<CalibrationRevision> Read(const std::filesystem::path& recording = {}) {
    const CalibrationContent content = *ParseCalibration(given_.calibration_text, "");
    folder_.Write("result/calibration.json", CalibrationText(content.calibration, given_.head.origin.run));
    folder_.Write("result/report.json", given_.report_text);
    return RevisionFromResult(folder_.Path() / "result", recording, "studio", given_.head.time, *store_);
  }

  TemporaryFolder folder_;
  std::unique_ptr<CalibrationStore> store_;
  CalibrationRevision given_;
};

TEST_F(ResultFolder, HoldsWhatTheStoreNeeds) {
  const auto revision = Read(folder_.Path() / "recording");
  ASSERT_TRUE(revision) << revision.error().message;
  const RevisionHead& head = revision->head;
  EXPECT_EQ(head.rig, "studio");
  EXPECT_EQ(head.verdict, Verdict::kRejected);
  EXPECT_EQ(head.reasons.size(), 1U);
  EXPECT_EQ(head.origin.recording_id, "night 7");
  EXPECT_EQ(head.origin.recording_sha256, given_.head.origin.run.inputs[0].sha256);
  EXPECT_EQ(head.origin.run.random_seed, given_.head.origin.run.random_seed);
  EXPECT_EQ(head.origin.run.options, given_.head.origin.run.options);
  EXPECT_FALSE(head.origin.seed_revision);
  EXPECT_EQ(revision->report_text, given_.report_text);
  EXPECT_TRUE(store_->Append(*revision));
}

TEST_F(ResultFolder, TheSeedIsTheRevisionWhoseCalibrationWasRead) {
  const CalibrationRevision seed = ExampleRevision("studio", 5);
  const int number = *store_->Append(seed);
  ASSERT_TRUE(store_->Append(ExampleRevision("studio", 6)));
  given_.head.origin.run.inputs.push_back({"calibration.json", Sha256Hex(seed.calibration_text)});
  EXPECT_EQ(Read()->head.origin.seed_revision, number);
}

TEST_F(ResultFolder, AnotherRecordingIsRefused) {
  given_.head.origin.run.inputs[0].sha256 = std::string(64, 'f');
  const auto revision = Read(folder_.Path() / "recording");
  ASSERT_FALSE(revision);
  EXPECT_THAT(revision.error().message, HasSubstr("is not the recording that the run has read"));
  EXPECT_TRUE(Read());
  EXPECT_FALSE(Read(folder_.Path() / "missing"));
}

}  // namespace
}  // namespace rigcal
