#include "config/result_folder.h"

#include <algorithm>
#include <limits>

#include "config/calibration_file.h"
#include "config/json_content.h"
#include "config/read_file.h"
#include "config/recording_file.h"
#include "config/run_report.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr DocumentFormat kRunReport = {"rigcal report", 1}, kSeedReport = {"rigcal seed report", 1};

/// null: a number that could not be determined.
double NumberFrom(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

ReportedVerdict OfRun(const Json& json) {
  ReportedVerdict reported;
  const auto word = json.at("verdict").get<std::string>();
  for (const Verdict verdict : {Verdict::kAccepted, Verdict::kRejected}) {
    if (word == NameOf(verdict)) reported.verdict = verdict;
  }
  if (word != NameOf(reported.verdict)) Refuse("the verdict is '{}'", word);
  for (const Json& entry : List(json, "reasons")) {
    Reason reason{.check = entry.at("check").get<std::string>(),
                  .value = NumberFrom(entry.at("value")),
                  .limit = NumberFrom(entry.at("limit")),
                  .unit = entry.at("unit").get<std::string>()};
    if (entry.contains("view")) reason.view = entry.at("view").get<std::string>();
    reported.reasons.push_back(ReasonText(reason));
  }
  return reported;
}

ReportedVerdict OfSeed(const Json& json) {
  ReportedVerdict reported;
  for (const Json& sentence : List(json, "contradictions")) reported.reasons.push_back(sentence.get<std::string>());
  if (reported.reasons.empty()) reported.verdict = Verdict::kAccepted;
  return reported;
}

/// The SHA-256 of the recording.json that the run has read; empty: none.
std::string RecordingHash(const Provenance& run) {
  const auto found = std::ranges::find(run.inputs, kRecordingFile, &InputFile::name);
  return found == run.inputs.end() ? "" : found->sha256;
}

Result<std::string> RecordingId(const std::filesystem::path& recording, const std::string& sha256) {
  if (recording.empty()) return std::string();
  const std::filesystem::path file = recording / kRecordingFile;
  const Result<std::string> text = ReadFile(file);
  if (!text) return text;
  if (const std::string actual = Sha256Hex(*text); actual != sha256) {
    return Fail(ErrorCode::kBadInput,
                "{}: is not the recording that the run has read (SHA-256 {:.12}..., not {:.12}...)", file.string(),
                actual, sha256.empty() ? "none" : sha256);
  }
  const Result<Recording> parsed = ParseRecording(*text, file.string());
  if (!parsed) return Fail(parsed.error());
  return parsed->id;
}

/// The newest revision whose calibration the run has read.
Result<std::optional<int>> SeedRevision(const Provenance& run, const std::string& rig, CalibrationStore& store) {
  const auto history = store.History(rig);
  if (!history) return Fail(history.error());
  for (auto head = history->revisions.rbegin(); head != history->revisions.rend(); ++head) {
    const bool was_read =
        std::ranges::find(run.inputs, head->calibration_sha256, &InputFile::sha256) != run.inputs.end();
    if (was_read) return head->number;
  }
  return std::nullopt;
}

}  // namespace

Result<ReportedVerdict> ParseReportedVerdict(std::string_view text, const std::string& file) {
  constexpr bool kThrow = false;
  const Json json = Json::parse(text, nullptr, kThrow);  // what is broken is told below
  const bool is_seed = json.is_object() && json.contains("format") && json["format"] == kSeedReport.name;
  if (is_seed) return ReadDocument<ReportedVerdict>(text, file, kSeedReport, OfSeed);
  return ReadDocument<ReportedVerdict>(text, file, kRunReport, OfRun);
}

Result<CalibrationRevision> RevisionFromResult(const std::filesystem::path& folder,
                                               const std::filesystem::path& recording, const std::string& rig,
                                               const std::string& time, CalibrationStore& store) {
  const std::filesystem::path calibration_file = folder / "calibration.json", report_file = folder / "report.json";
  Result<std::string> calibration = ReadFile(calibration_file);
  if (!calibration) return Fail(calibration.error());
  Result<std::string> report = ReadFile(report_file);
  if (!report) return Fail(report.error());
  auto content = ParseCalibration(*calibration, calibration_file.string());
  if (!content) return Fail(content.error());
  auto reported = ParseReportedVerdict(*report, report_file.string());
  if (!reported) return Fail(reported.error());

  CalibrationRevision revision{.calibration_text = std::move(*calibration), .report_text = std::move(*report)};
  RevisionHead& head = revision.head;
  head.rig = rig;
  head.time = time;
  head.verdict = reported->verdict;
  head.reasons = std::move(reported->reasons);
  head.origin.run = std::move(content->provenance);
  head.origin.recording_sha256 = RecordingHash(head.origin.run);
  Result<std::string> id = RecordingId(recording, head.origin.recording_sha256);
  if (!id) return Fail(id.error());
  head.origin.recording_id = std::move(*id);
  const auto seed = SeedRevision(head.origin.run, rig, store);
  if (!seed) return Fail(seed.error());
  head.origin.seed_revision = *seed;
  return revision;
}

}  // namespace rigcal
