#include "config/rig_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <variant>

#include "config/read_file.h"
#include "config/rig_file.h"
#include "config/rig_summary.h"
#include "core/scene/rig_devices.h"
#include "sim_fixtures/render.h"
#include "sim_fixtures/shape.h"
#include "sim_fixtures/studio.h"
#include "tests/config/example_rig_file.h"
#include "tests/config/refusals.h"

namespace rigcal {
namespace {

using Default = std::variant<double, std::string, bool>;

/// What the program does without each key: "TABLE.KEY", or "TABLE.KEY KIND" where a kind of positioner has its own.
std::map<std::string, Default> Defaults() {
  const CameraSettings camera;
  const PositionerSettings positioner;
  const AxisSettings axis;
  const CaptureSettings capture;
  const SimSettings sim;
  const RigModel table = Turntable(), gantry = Gantry(kMaxGantryAxes, PositionerLoad::kObject),
                 arm = Arm(PositionerLoad::kObject);
  return {
      {"positioner.carries", "object"},
      {"positioner.step_sigma_deg", table.error_sigma[kStep]},
      {"positioner.wobble_sigma_deg", table.error_sigma[kWobbleX]},
      {"positioner.run_out_sigma_m", table.error_sigma[kRunOutX]},
      {"positioner.lift_sigma_m", table.error_sigma[kLift]},
      {"positioner.position_sigma_m gantry", gantry.error_sigma[3]},
      {"positioner.position_sigma_m arm", arm.error_sigma[3]},
      {"positioner.rotation_sigma_deg", arm.error_sigma[0]},
      {"positioner.axis_scale_sigma", gantry.axis_scale_sigma},
      {"positioner.settle_s", positioner.settle_s},
      {"positioner.move_timeout_s", positioner.move_timeout_s},
      {"positioner.tolerance_deg", positioner.position_tolerance_rad},
      {"positioner.tolerance_m", positioner.position_tolerance_m},
      {"positioner.axis.backlash_deg", axis.backlash},
      {"positioner.axis.backlash_m", axis.backlash},
      {"stops.start_deg", 0.0},
      {"camera.pixel_format", camera.pixel_format},
      {"camera.trigger", camera.trigger == CameraTrigger::kSoftware ? "software" : "hardware"},
      {"capture.picture_s", capture.picture_s},
      {"capture.recover_s", capture.recover_s},
      {"capture.retakes", static_cast<double>(capture.retakes)},
      {"capture.max_saturated", capture.max_saturated},
      {"capture.min_brightness", capture.min_brightness},
      {"capture.min_sharpness", capture.min_sharpness},
      {"capture.refuse_identical", capture.refuse_identical},
      {"publish.undistorted", PublishSettings{}.undistorted},
      {"replay.at_recorded_speed", ReplaySettings{}.at_recorded_speed},
      {"sim.scene", sim.scene},
      {"sim.surroundings", sim.surroundings},
      {"sim.width_px", static_cast<double>(sim.width_px)},
      {"sim.height_px", static_cast<double>(sim.height_px)},
      {"sim.step_error_deg", sim.step_error_rad},
      {"sim.wobble_deg", sim.wobble_rad},
      {"sim.run_out_m", sim.run_out_m},
      {"sim.blur_sigma_px", sim.blur_sigma_px},
      {"sim.noise_sigma", sim.noise_sigma},
      {"sim.random_seed", static_cast<double>(sim.random_seed)},
  };
}

std::optional<double> NumberIn(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// What a documented default means; nothing for one in words.
std::optional<Default> Documented(const RigKey& key) {
  if (key.fallback == "true" || key.fallback == "false") return key.fallback == "true";
  if (key.fallback.starts_with('"')) return std::string(key.fallback.substr(1, key.fallback.size() - 2));
  const auto number = NumberIn(key.fallback);
  return number ? std::optional<Default>(*number * key.unit.to_si) : std::nullopt;
}

bool Same(const Default& a, const Default& b) {
  constexpr double kThreeDigits = 5e-3;  // as documented
  if (!std::holds_alternative<double>(a) || !std::holds_alternative<double>(b)) return a == b;
  const double x = std::get<double>(a), y = std::get<double>(b);
  return std::abs(x - y) <= kThreeDigits * std::abs(x);
}

TEST(RigKeys, DocumentTheDefaultsOfTheProgram) {
  std::map<std::string, Default> defaults = Defaults();
  std::set<std::string> documented;
  for (const RigTable& table : RigTables()) {
    for (const RigKey& key : table.keys) {
      const auto means = Documented(key);
      if (!means) continue;
      std::string name = fmt::format("{}.{}", table.name, key.name);
      if (!defaults.contains(name)) name += fmt::format(" {}", key.of);
      ASSERT_TRUE(defaults.contains(name)) << name << " has a default that no test compares";
      EXPECT_TRUE(Same(*means, defaults.at(name))) << name << ": " << key.fallback;
      documented.insert(name);
    }
  }
  EXPECT_EQ(documented.size(), defaults.size());
  EXPECT_EQ(RigTableNamed("positioner").Find("axes", "turntable")->fallback, fmt::format("[\"{}\"]", kTableAxis));
}

TEST(RigKeys, DefaultsLieInTheirRanges) {
  for (const RigTable& table : RigTables()) {
    for (const RigKey& key : table.keys) {
      const auto number = NumberIn(key.fallback);
      if (!number) continue;
      EXPECT_GE(*number, key.least) << table.name << "." << key.name;
      EXPECT_LE(*number, key.most) << table.name << "." << key.name;
    }
  }
}

TEST(RigKeys, SayUnitAndMeaningOfEach) {
  const std::set<std::string_view> kinds = {"", "turntable", "gantry", "arm", "turntable, gantry", "gantry, arm"};
  for (const RigTable& table : RigTables()) {
    std::set<std::pair<std::string_view, std::string_view>> rows;
    for (const RigKey& key : table.keys) {
      SCOPED_TRACE(fmt::format("{}.{}", table.name, key.name));
      EXPECT_TRUE(key.name.ends_with(key.unit.suffix));
      EXPECT_FALSE(key.meaning.empty());
      EXPECT_FALSE(key.fallback.empty());
      EXPECT_TRUE(kinds.contains(key.of)) << key.of;
      EXPECT_EQ(key.type == KeyType::kWord, !key.words.empty());
      EXPECT_TRUE(rows.emplace(key.name, key.of).second) << "there is one row of a key for a kind";
    }
  }
}

TEST(RigKeys, LimitsOfTheSimulatedStudioAreItsOwn) {
  const RigTable& table = RigTableNamed("sim");
  const auto key = [&](std::string_view name) { return *table.Find(name, ""); };
  EXPECT_EQ(std::vector<std::string>(key("scene").words.begin(), key("scene").words.end()), sim::SceneNames());
  for (const std::string_view word : key("surroundings").words) EXPECT_TRUE(sim::SurroundingsFromName(word)) << word;
  EXPECT_EQ(key("num_cameras").most, sim::kMaxCameras);
  EXPECT_EQ(key("width_px").least, sim::kMinSide_px);
  EXPECT_EQ(key("height_px").most, sim::kMaxSide_px);
  EXPECT_EQ(key("step_error_deg").most, sim::kMaxStepError_deg);
  EXPECT_EQ(key("wobble_deg").most, sim::kMaxWobble_deg);
  EXPECT_EQ(key("run_out_m").most, sim::kMaxRunOut_mm / 1000);
  const sim::StudioOptions studio;
  const SimSettings settings;
  EXPECT_EQ(settings.scene, sim::NameOf(studio.scene));
  EXPECT_EQ(settings.surroundings, sim::NameOf(studio.surroundings));
  EXPECT_EQ(settings.num_cameras, studio.num_cameras);
  EXPECT_EQ(settings.width_px, studio.width_px);
  EXPECT_EQ(settings.height_px, studio.height_px);
  EXPECT_EQ(settings.random_seed, studio.random_seed);
  EXPECT_EQ(settings.blur_sigma_px, sim::SensorOptions{}.blur_sigma_px);
  EXPECT_EQ(settings.noise_sigma, sim::SensorOptions{}.noise_sigma);
}

TEST(RigKeys, AreThoseOfTheDocumentation) {
  const Result<std::string> page = ReadFile(RIGCAL_SCHEMA_DIR "/../rig_keys.md");
  ASSERT_TRUE(page) << Message(page);
  EXPECT_EQ(*page, RigKeysMarkdown()) << "write it anew: rigcal rig keys > docs/rig_keys.md";
}

/// The indented blocks of a markdown page that hold a positioner.
std::vector<std::string> RigExamples(const std::string& page) {
  constexpr std::size_t kIndent = 4;
  std::vector<std::string> blocks(1);
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("    "))
      blocks.back() += line.substr(kIndent) + "\n";
    else if (!line.empty())
      blocks.emplace_back();
  }
  std::erase_if(blocks, [](const std::string& block) { return !block.starts_with("[positioner]"); });
  return blocks;
}

TEST(RigKeys, TheDocumentedExamplesAreRigFiles) {
  const Result<std::string> page = ReadFile(RIGCAL_SCHEMA_DIR "/../rig.md");
  ASSERT_TRUE(page) << Message(page);
  const std::vector<std::string> examples = RigExamples(*page);
  EXPECT_EQ(examples.size(), 3u);
  for (const std::string& example : examples) EXPECT_EQ(Message(ParseRig(example, "rig.toml")), kNoError) << example;
}

TEST(RigSummary, SaysWhatTheRigIs) {
  const auto summary = [](const char* text) {
    const Result<RigFile> rig = ParseRig(text, "rig.toml");
    return rig ? RigSummaryText(*rig) : rig.error().message;
  };
  EXPECT_EQ(summary(kWholeRig),
            "positioner: turntable, carries the object; driver linuxcnc at 127.0.0.1:5007, settles 0.25 s\n"
            "axis table: C, -10 deg to 370 deg, 20 deg/s, reached while it grows, from 2 deg beyond\n"
            "stops: 4, table 10 deg to 280 deg\n"
            "camera left: genicam, serial S1, BayerRG12, 8000 us, 1.5 dB, hardware trigger\n"
            "camera right: genicam, address 127.0.0.2, Mono8\n"
            "chart: board.toml\n"
            "rig 'studio' of the store; published in published, also as colmap, opencv\n"
            "recordings: 30 days, at most 100, 20 GB of the disk free\n");
  EXPECT_EQ(summary(kGantryRig),
            "positioner: gantry, carries the cameras; driver grbl at /dev/ttyUSB0, settles 0.5 s\n"
            "axis x: X, no soft limits\n"
            "axis z: Z, 0 m to 0.5 m, 0.1 m/s, reached while it shrinks, from 0.002 m beyond\n"
            "stops: 2, x 0 m to 0.2 m, z 0.1 m to 0.1 m\n"
            "cameras: none\n"
            "recordings: all are kept\n");
  EXPECT_EQ(summary(kSimRig),
            "positioner: turntable, carries the object; driver sim, settles 0.5 s\n"
            "axis table: no soft limits\n"
            "stops: 12, table 0 deg to 330 deg\n"
            "camera cam0: sim, Mono8\n"
            "camera cam1: sim, Mono8\n"
            "camera cam2: sim, Mono8\n"
            "simulated studio: plaster, 3 cameras of 1280 x 960 px\n"
            "recordings: all are kept\n");
  EXPECT_EQ(summary("[positioner]\nkind = \"arm\"\ncarries = \"cameras\"\n"),
            "positioner: arm, carries the cameras; no driver, stops are made by hand\n"
            "stops: the arm tells them\n"
            "cameras: none\n"
            "recordings: all are kept\n");
}

}  // namespace
}  // namespace rigcal
