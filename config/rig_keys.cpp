#include "config/rig_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "config/positioner_names.h"
#include "core/base/ensure.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

using enum KeyType;

template <typename Value, std::size_t kCount>
constexpr std::array<std::string_view, kCount> WordsOf(
    const std::array<std::pair<std::string_view, Value>, kCount>& of) {
  std::array<std::string_view, kCount> words;
  for (std::size_t i = 0; i < kCount; ++i) words[i] = of[i].first;
  return words;
}
constexpr auto kKinds = WordsOf(kPositionerKinds);
constexpr auto kLoads = WordsOf(kPositionerLoads);
constexpr std::array<std::string_view, 5> kPositionerDrivers = {"linuxcnc", "grbl", "arm", "replay", "sim"};
constexpr std::array<std::string_view, 3> kCameraDrivers = {"genicam", "replay", "sim"};
constexpr std::array<std::string_view, 2> kApproaches = {"up", "down"};
constexpr std::array<std::string_view, 9> kLetters = {"X", "Y", "Z", "A", "B", "C", "U", "V", "W"};  // LinuxCNC's
constexpr std::array<std::string_view, 2> kTriggers = {"software", "hardware"};
constexpr std::array<std::string_view, 3> kScenes = {"textured", "plaster", "thin"};
constexpr std::array<std::string_view, 2> kSurroundings = {"black", "backdrop"};
constexpr std::array<std::string_view, 20> kPixelFormats = {
    "Mono8",     "Mono10",    "Mono12",    "Mono16",    "BayerRG8",  "BayerRG10", "BayerRG12",
    "BayerRG16", "BayerGB8",  "BayerGB10", "BayerGB12", "BayerGB16", "BayerGR8",  "BayerGR10",
    "BayerGR12", "BayerGR16", "BayerBG8",  "BayerBG10", "BayerBG12", "BayerBG16"};
constexpr std::string_view kTurntable = "turntable", kGantry = "gantry", kArm = "arm";

struct Span {
  double least, most;
};
struct Length {
  int fewest, longest;
};

constexpr RigKey Text(std::string_view name, std::string_view fallback, std::string_view meaning,
                      std::string_view of = "") {
  return {.name = name, .fallback = fallback, .meaning = meaning, .of = of};
}
constexpr RigKey Name(std::string_view name, std::string_view fallback, std::string_view meaning) {
  return {.name = name, .type = kName, .fallback = fallback, .meaning = meaning};
}
constexpr RigKey Flag(std::string_view name, std::string_view fallback, std::string_view meaning) {
  return {.name = name, .type = kFlag, .fallback = fallback, .meaning = meaning};
}
constexpr RigKey Word(std::string_view name, std::span<const std::string_view> words, std::string_view fallback,
                      std::string_view meaning, std::string_view of = "") {
  return {.name = name, .type = kWord, .words = words, .fallback = fallback, .meaning = meaning, .of = of};
}
constexpr RigKey Number(std::string_view name, const KeyUnit& unit, Span range, std::string_view fallback,
                        std::string_view meaning, std::string_view of = "") {
  return {.name = name,
          .type = kNumber,
          .unit = unit,
          .least = range.least,
          .most = range.most,
          .fallback = fallback,
          .meaning = meaning,
          .of = of};
}
constexpr RigKey Whole(std::string_view name, const KeyUnit& unit, Span range, std::string_view fallback,
                       std::string_view meaning, std::string_view of = "") {
  RigKey key = Number(name, unit, range, fallback, meaning, of);
  key.type = kWhole;
  return key;
}
constexpr RigKey Texts(std::string_view name, Length length, std::string_view fallback, std::string_view meaning,
                       std::string_view of) {
  RigKey key = Text(name, fallback, meaning, of);
  key.type = kTexts, key.fewest = length.fewest, key.longest = length.longest;
  return key;
}
constexpr RigKey List(std::string_view name, KeyType type, const KeyUnit& unit, Span range, Length length,
                      std::string_view fallback, std::string_view meaning, std::string_view of = "") {
  RigKey key = Number(name, unit, range, fallback, meaning, of);
  key.type = type, key.fewest = length.fewest, key.longest = length.longest;
  return key;
}

// Beyond, a position says nothing.
constexpr double kMaxSigma_deg = 10, kMaxSigma_m = 0.1, kMaxScaleSigma = 0.1;
constexpr int kMostStops = 3600;  // a tenth of a degree of a turn
constexpr double kMostTravel_deg = 36000, kMostTravel_m = 100;
constexpr int kMostSensor_px = 65536;
constexpr int kMostFormats = 16;                                    // more than there are
constexpr int kLeastPacket_bytes = 576, kMostPacket_bytes = 16384;  // GigE Vision's least; the largest of network cards

constexpr std::array kPositionerKeys = {
    Word("kind", kKinds, kRequired, "what moves"),
    Word("carries", kLoads, "\"object\"", "a turntable carries the object", kTurntable),
    Word("carries", kLoads, kRequired, "what moves with it", "gantry, arm"),
    Texts("axes", {1, 1}, "[\"table\"]", "the axis's name in the recording's stops", kTurntable),
    Texts("axes", {1, kMaxGantryAxes}, "the names of its [[positioner.axis]]",
          "the axes' names in the recording's stops", kGantry),
    Number("step_sigma_deg", kDegrees, {0, kMaxSigma_deg}, "0.0286", "standard deviation of a stop's angle",
           kTurntable),
    Number("wobble_sigma_deg", kDegrees, {0, kMaxSigma_deg}, "0.0201", "tilt of the table about each of two directions",
           kTurntable),
    Number("run_out_sigma_m", kMetres, {0, kMaxSigma_m}, "1e-5", "shift of the axis in each of two directions",
           kTurntable),
    Number("lift_sigma_m", kMetres, {0, kMaxSigma_m}, "0", "shift along the axis", kTurntable),
    Number("position_sigma_m", kMetres, {0, kMaxSigma_m}, "5e-5", "error of each axis", kGantry),
    Number("position_sigma_m", kMetres, {0, kMaxSigma_m}, "1e-4", "error of the flange along each direction", kArm),
    Number("rotation_sigma_deg", kDegrees, {0, kMaxSigma_deg}, "0.0115", "error of the flange about each direction",
           kArm),
    Number("axis_scale_sigma", kPlain, {0, kMaxScaleSigma}, "1e-3", "relative error of an axis's unit of length",
           kGantry),
    Word("driver", kPositionerDrivers, "none: stops are made by hand", "what rigcal moves it with"),
    Text("address", "none; linuxcnc, grbl and arm need one",
         "linuxcnc: HOST:PORT of linuxcncrsh; grbl: the serial device; arm: HOST:PORT to listen on, or a file "
         "of poses"),
    Number("settle_s", kSeconds, {0, 60}, "0.5", "wait after a move has ended, before a picture is taken"),
    Number("move_timeout_s", kSeconds, {1, 3600}, "120", "a move that takes longer has failed"),
    Number("tolerance_deg", kDegrees, {1e-4, 5}, "0.0974", "how far the reported angle may be from the commanded one",
           kTurntable),
    Number("tolerance_m", kMetres, {1e-6, kMaxSigma_m}, "1e-4",
           "how far a reported position may be from the commanded one", kGantry),
    Number("tolerance_deg", kDegrees, {1e-4, 5}, "0.0974",
           "how far the flange may be turned from where it was when a stop is resumed", kArm),
    Number("tolerance_m", kMetres, {1e-6, kMaxSigma_m}, "1e-4",
           "how far the flange may be from where it was when a stop is resumed", kArm),
};

constexpr std::string_view kMoving = "turntable, gantry";
constexpr std::array kAxisKeys = {
    Text("name", "the name in `axes`, \"table\"", "which axis", kTurntable),
    Text("name", kRequired, "which axis", kGantry),
    Word("letter", kLetters, "the name where it is a letter; turntable: C, with grbl X",
         "what the controller calls it; grbl has X, Y and Z", kMoving),
    List("limits_deg", kNumbers, kDegrees, {-kMostTravel_deg, kMostTravel_deg}, {2, 2}, "none of rigcal's own",
         "soft limits, [least, most]", kTurntable),
    List("limits_m", kNumbers, kMetres, {-kMostTravel_m, kMostTravel_m}, {2, 2}, "none of rigcal's own",
         "soft limits, [least, most]", kGantry),
    Number("speed_deg_s", kDegreesPerSecond, {0.001, 720}, "the controller's own", "of every move", kTurntable),
    Number("speed_m_s", kMetresPerSecond, {1e-5, 10}, "the controller's own", "of every move", kGantry),
    Word("approach", kApproaches, "as it comes", "a stop is always reached while the axis grows (up) or shrinks (down)",
         kMoving),
    Number("backlash_deg", kDegrees, {0, 30}, "0",
           "how far it goes beyond a stop to come back from the side of `approach`", kTurntable),
    Number("backlash_m", kMetres, {0, 0.05}, "0",
           "how far it goes beyond a stop to come back from the side of `approach`", kGantry),
};

constexpr std::array kStopKeys = {
    List("angles_deg", kNumbers, kDegrees, {-kMostTravel_deg, kMostTravel_deg}, {1, kMostStops}, "none",
         "every stop; in place of the next three", kTurntable),
    Whole("count", kPlain, {1, kMostStops}, "none", "number of stops", kTurntable),
    Number("start_deg", kDegrees, {-kMostTravel_deg, kMostTravel_deg}, "0", "the first stop", kTurntable),
    Number("step_deg", kDegrees, {-360, 360}, "360 / count", "from a stop to the next", kTurntable),
    List("positions_m", kNumberRows, kMetres, {-kMostTravel_m, kMostTravel_m}, {1, kMostStops}, "none",
         "every stop: a list with one position for each axis, in the order of `axes`", kGantry),
};

constexpr std::array kCameraKeys = {
    Name("id", kRequired, "its name in recordings and calibrations"),
    Word("driver", kCameraDrivers, kRequired, "what rigcal opens it with"),
    Text("serial", "found by its address", "serial number, in quotes; genicam needs it or an address"),
    Text("address", "found by its serial number", "IPv4 address, or port path of a USB camera (\"1-2.3\")"),
    Word("pixel_format", kPixelFormats, "\"Mono8\"", "GenICam's name of it"),
    Word("trigger", kTriggers, "\"software\"", "whether rigcal fires it, or a line from the positioner"),
    Number("exposure_us", kMicroseconds, {1, 6e7}, "as the camera has it", "exposure time"),
    Number("gain_db", kDecibels, {-20, 60}, "as the camera has it", "gain"),
    Whole("packet_bytes", kBytes, {kLeastPacket_bytes, kMostPacket_bytes}, "negotiated",
          "packet size of a GigE Vision camera"),
    List("region_px", kWholes, kPixels, {0, kMostSensor_px}, {4, 4}, "as the camera has it",
         "the part of the sensor that is read: [left, top, width, height]"),
    Text("lens", "unknown", "for the recording"),
    Number("focus_m", kMetres, {0.001, 1000}, "unknown", "distance of focus, for the recording"),
};

constexpr std::array kCaptureKeys = {
    Number("picture_s", kSeconds, {0.1, 600}, "4", "a picture that has not come within it is missing"),
    Number("recover_s", kSeconds, {0, 600}, "8",
           "how long a failed camera is given to come back; a lost one is told after picture_s and this"),
    Whole("retakes", kPlain, {0, 100}, "2", "how often a picture is taken again after the first"),
    Number("max_saturated", kPlain, {0, 1}, "0.5", "share of saturated pixels; a picture with more is taken again"),
    Number("min_brightness", kPlain, {0, 1}, "0.01",
           "mean of the brightest hundredth of the pixels, share of full scale"),
    Number("min_sharpness", kPlain, {0, 1}, "0.3", "against the same camera's last good picture; lower is blurred"),
    Flag("refuse_identical", "true", "the same picture twice in a row is that of a camera that hangs"),
};

constexpr std::array kKeepKeys = {
    Number("max_age_days", kDays, {0.01, 36500}, "any age", "older recordings go"),
    Whole("max_count", kPlain, {1, 1e6}, "any number", "the oldest go until there are no more than this"),
    Number("min_free_gb", kGigabytes, {0.001, 1e6}, "no limit", "the oldest go until so much of the disk is free"),
};

constexpr std::array kPublishKeys = {
    Name("rig", "the rig file's name without .toml", "its name in the calibration store"),
    Text("folder", "`published` in the state folder",
         "where the calibration in force is written to, relative to the rig file"),
    Texts("formats", {1, kMostFormats}, "current.json alone", "formats of `rigcal export` that are written there, too",
          ""),
    Flag("undistorted", "false", "those formats are for undistorted images"),
};

constexpr std::array kDriftKeys = {
    Number("limit_px", kPixels, {0.01, 10}, "0.15: half of the smallest drift that must be found",
           "a camera drifts when its picture of the object has moved by more than this"),
};

constexpr std::array kChartKeys = {
    Text("board", kRequired, "board.toml ([charts](chart.md)), relative to the rig file"),
};

constexpr std::array kReplayKeys = {
    Text("recording", kRequired, "its folder, relative to the rig file"),
    Flag("at_recorded_speed", "false", "otherwise as fast as it goes"),
};

constexpr std::array kSimKeys = {
    Word("scene", kScenes, "\"textured\"", "what stands on the table"),
    Word("surroundings", kSurroundings, "\"black\"", "a dark cloth, or textured walls and table top"),
    Whole("num_cameras", kPlain, {1, 16}, "as many as [[camera]] of the driver sim; 1 without",
          "cameras of the studio; without any [[camera]] they are called cam0, cam1, ..."),
    Whole("width_px", kPixels, {64, 8192}, "1280", "of every picture"),
    Whole("height_px", kPixels, {64, 8192}, "960", "of every picture"),
    Number("step_error_deg", kDegrees, {0, 5}, "0", "standard deviation of the true angles of the stops"),
    Number("wobble_deg", kDegrees, {0, 5}, "0", "of the table's tilt, about each of two directions"),
    Number("run_out_m", kMetres, {0, 0.01}, "0", "of its shift, along each of two directions"),
    Number("blur_sigma_px", kPixels, {0, 10}, "0.5", "sigma of the lens"),
    Number("noise_sigma", kPlain, {0, 100}, "1", "sigma in grey levels of 8 bit"),
    Whole("random_seed", kPlain, {0, 1e6}, "1", "of noise and errors"),
};

constexpr std::array kTables = {
    RigTable{"positioner", false, kPositionerKeys, "What moves, how exactly it repeats, and how it is driven."},
    RigTable{"positioner.axis", true, kAxisKeys,
             "One axis of a turntable or gantry; what is left out has its default."},
    RigTable{"stops", false, kStopKeys, "Where pictures are taken. An arm tells its stops itself."},
    RigTable{"camera", true, kCameraKeys, "One physical camera."},
    RigTable{"capture", false, kCaptureKeys, "How pictures are taken, checked and taken again."},
    RigTable{"keep", false, kKeepKeys,
             "When old recordings go (`rigcal recording prune`). What a revision needs never goes."},
    RigTable{"publish", false, kPublishKeys,
             "Where the service, rigcald, publishes what it finds ([store](store.md))."},
    RigTable{"drift", false, kDriftKeys, "When a calibration in force no longer holds (`rigcal drift-check`)."},
    RigTable{"chart", false, kChartKeys, "The board of `rigcal capture --what chart`."},
    RigTable{"replay", false, kReplayKeys, "The recording that stands behind devices of the driver replay."},
    RigTable{"sim", false, kSimKeys, "The simulated studio that stands behind devices of the driver sim."},
};

std::string CountWord(int count) {
  constexpr std::array kWords = {"no", "one", "two", "three", "four"};
  return count < static_cast<int>(kWords.size()) ? kWords[count] : std::to_string(count);
}

}  // namespace

std::string RigTable::Title() const {
  return repeated ? fmt::format("[[{}]]", name) : fmt::format("[{}]", name);
}

const RigKey* RigTable::Find(std::string_view key, std::string_view kind) const {
  const auto found = std::ranges::find_if(keys, [&](const RigKey& row) { return row.name == key && row.IsOf(kind); });
  return found == keys.end() ? nullptr : &*found;
}

bool RigKey::IsOf(std::string_view kind) const {
  return of.empty() || of.find(kind) != std::string_view::npos;
}

std::string KeyDescription(const RigKey& key) {
  const std::string unit = *key.unit.words == '\0' ? "" : fmt::format(" in {}", key.unit.words);
  const std::string range = fmt::format("{} from {:.6g} to {:.6g}", unit, key.least, key.most);
  const std::string length = key.fewest == key.longest
                                 ? CountWord(key.fewest)
                                 : fmt::format("{} to {}", CountWord(key.fewest), CountWord(key.longest));
  switch (key.type) {
    case kText:
      return fmt::format("a text in quotes of 1 to {} characters", kMaxTextLength);
    case kName:
      return fmt::format("a name in quotes of 1 to {} letters, digits, '-' and '_'", kMaxNameLength);
    case kWord: {
      std::vector<std::string> quoted;
      for (const std::string_view word : key.words) quoted.push_back(fmt::format("\"{}\"", word));
      return "one of " + Joined(quoted, ", ");
    }
    case kFlag:
      return "true or false";
    case kNumber:
      return "a number" + range;
    case kWhole:
      return "a whole number" + range;
    case kNumbers:
      return fmt::format("a list of {} numbers{}", length, range);
    case kWholes:
      return fmt::format("a list of {} whole numbers{}", length, range);
    case kNumberRows:
      return fmt::format("a list of {} lists of numbers{}", length, range);
    case kTexts:
      return fmt::format("a list of {} in quotes", key.longest == 1 ? "one name" : length + " names");
  }
  return "";
}

std::span<const RigTable> RigTables() {
  return kTables;
}

const RigTable& RigTableNamed(std::string_view name) {
  const auto found = std::ranges::find(kTables, name, &RigTable::name);
  Ensure(found != kTables.end(), "the rig file has such a table");
  return *found;
}

}  // namespace rigcal
