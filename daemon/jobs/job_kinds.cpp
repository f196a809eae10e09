#include "daemon/jobs/job_kinds.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/joined.h"
#include "daemon/capture_request.h"

namespace rigcal {
namespace {

using Json = nlohmann::json;
using Type = RequestKey::Type;

constexpr std::size_t kMaxText = 4096;   // the longest path of Linux
constexpr std::size_t kMaxStops = 3600;  // as [stops] of a rig file
constexpr double kMostStop = 36000;      // degrees; as [stops] of a rig file

constexpr RequestKey kRecording{.name = "recording"};
constexpr RequestKey kRecordingNeeded{.name = "recording", .required = true};
constexpr RequestKey kStops{.name = "stops", .type = Type::kNumbers, .least = -kMostStop, .most = kMostStop};
constexpr RequestKey kMasks{.name = "masks", .type = Type::kMasks};
// The ranges of `rigcal refine`.
constexpr RequestKey kRounds{.name = "rounds", .type = Type::kWhole, .least = 1, .most = 20};
constexpr RequestKey kExpectedError{.name = "expected_error_px", .type = Type::kNumber, .least = 0.1, .most = 31};
constexpr RequestKey kRandomSeed{.name = "random_seed", .type = Type::kWhole, .least = 0, .most = 1e9};

constexpr std::array kCaptureKeys = {kRecording, kStops, RequestKey{.name = "what", .type = Type::kSubject}};
constexpr std::array kSeedKeys = {kRecording, kStops};
constexpr std::array kRecalibrateKeys = {kRecording, kStops, kMasks, kRounds, kExpectedError, kRandomSeed};
constexpr std::array kReplayKeys = {kRecordingNeeded, kMasks, kRounds, kExpectedError, kRandomSeed};

constexpr std::array<JobKind, 4> kKinds = {{
    {"capture", "takes a recording", kCaptureKeys, CaptureJob},
    {"seed-chart", "takes pictures of the chart and calibrates the rig from them", kSeedKeys, SeedChartJob},
    {"recalibrate", "takes pictures of the object and refines the calibration in force", kRecalibrateKeys,
     RecalibrateJob},
    {"replay", "refines the calibration in force from a recording", kReplayKeys, ReplayJob},
}};

bool IsNumber(const Json& value, const RequestKey& key) {
  if (!value.is_number()) return false;
  const double number = value.get<double>();
  return std::isfinite(number) && number >= key.least && number <= key.most;
}

bool Fits(const Json& value, const RequestKey& key) {
  const auto* text = value.get_ptr<const std::string*>();
  switch (key.type) {
    case Type::kText:
      return text && !text->empty() && text->size() <= kMaxText && text->find('\0') == std::string::npos;
    case Type::kSubject:
      return text && SubjectNamed(*text).has_value();
    case Type::kMasks:
      return text && (*text == "auto" || *text == "none");
    case Type::kNumber:
      return IsNumber(value, key);
    case Type::kWhole:
      return value.is_number_integer() && IsNumber(value, key);
    case Type::kNumbers:
      return value.is_array() && !value.empty() && value.size() <= kMaxStops &&
             std::ranges::all_of(value, [&](const Json& number) { return IsNumber(number, key); });
  }
  return false;
}

std::string Needed(const RequestKey& key) {
  switch (key.type) {
    case Type::kText:
      return fmt::format("a text of 1 to {} characters", kMaxText);
    case Type::kSubject:
      return "\"chart\", \"object\" or \"both\"";
    case Type::kMasks:
      return "\"auto\" or \"none\"";
    case Type::kNumber:
      return fmt::format("a number from {} to {}", key.least, key.most);
    case Type::kWhole:
      return fmt::format("a whole number from {} to {}", key.least, key.most);
    case Type::kNumbers:
      return fmt::format("a list of 1 to {} numbers from {} to {}", kMaxStops, key.least, key.most);
  }
  return "";
}

}  // namespace

std::span<const JobKind> JobKinds() {
  return kKinds;
}

const JobKind* FindJobKind(std::string_view name) {
  const auto found = std::ranges::find(kKinds, name, &JobKind::name);
  return found == kKinds.end() ? nullptr : &*found;
}

Result<void> CheckJobRequest(const JobKind& kind, const Json& request) {
  if (!request.is_object()) return Fail(ErrorCode::kBadInput, "{}: the request must be an object", kind.name);
  for (const auto& [name, value] : request.items()) {
    const auto key = std::ranges::find(kind.keys, name, &RequestKey::name);
    if (key == kind.keys.end()) {
      std::vector<std::string> known;
      for (const RequestKey& row : kind.keys) known.emplace_back(row.name);
      return Fail(ErrorCode::kBadInput, "{}: '{}' is no key of its request, those are {}", kind.name, name,
                  Joined(known, ", "));
    }
    if (!Fits(value, *key)) return Fail(ErrorCode::kBadInput, "{}: '{}' must be {}", kind.name, name, Needed(*key));
  }
  for (const RequestKey& key : kind.keys) {
    if (key.required && !request.contains(std::string(key.name))) {
      return Fail(ErrorCode::kBadInput, "{}: '{}' is missing, {}", kind.name, key.name, Needed(key));
    }
  }
  return {};
}

}  // namespace rigcal
