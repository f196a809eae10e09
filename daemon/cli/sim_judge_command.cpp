#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "config/patches_file.h"
#include "config/points_file.h"
#include "config/read_file.h"
#include "daemon/cli/command.h"
#include "daemon/cli/number_options.h"
#include "daemon/cli/sim_commands.h"
#include "daemon/cli/sim_folder.h"
#include "daemon/run_context.h"

namespace rigcal {
namespace {

constexpr int kMaxLevel = 8;
constexpr double kFarOff_level_px = 2;  ///< pixels of the level from which a patch counts as wrong

Result<sim::Studio> ReadStudio(const std::filesystem::path& set, const Execution& execution) {
  const std::filesystem::path file = set / "truth.json";
  const Result<std::string> text = ReadFile(file);
  if (!text) return Fail(text.error());
  return sim::StudioFromTruth(*text, file.string(), execution);
}

struct JudgeRequest {
  std::filesystem::path set, patches;
  int level = 0;
  int num_threads = 0;  ///< 0: one for each processor
};

Result<void> Judge(const JudgeRequest& request, const CommandSession& session) {
  const Execution execution{
      .stop = session.stop, .num_threads = NumThreads(request.num_threads), .report_progress = {}};
  const Result<std::string> bytes = ReadFile(request.patches);
  if (!bytes) return Fail(bytes.error());
  const auto vertices = ParsePatches(*bytes, request.patches.string());
  if (!vertices) return Fail(vertices.error());
  if (vertices->empty()) return Fail(ErrorCode::kBadInput, "{}: has no patches to judge", request.patches.string());
  const Result<sim::Studio> studio = ReadStudio(request.set, execution);
  if (!studio) return Fail(studio.error());
  std::vector<Eigen::Vector3d> centres_in_world;
  for (const PatchVertex& vertex : *vertices) centres_in_world.push_back(vertex.centre_in_world.cast<double>());
  std::vector<double> off_px = sim::DistancesToSurface_px(*studio, centres_in_world, execution);
  if (off_px.empty()) return Cancelled("judging patches");
  std::sort(off_px.begin(), off_px.end());
  const double far_px = kFarOff_level_px * std::ldexp(1.0, request.level);
  const auto far = off_px.end() - std::upper_bound(off_px.begin(), off_px.end(), far_px);
  const auto count = static_cast<double>(off_px.size());
  fmt::print("{} patches, off the surface (full-size pixels): median {:.3f}, p90 {:.3f}; {:.2f} % above {:g} px\n",
             off_px.size(), off_px[off_px.size() / 2], off_px[off_px.size() * 9 / 10],
             100 * static_cast<double>(far) / count, far_px);
  return {};
}

struct DisturbRequest {
  std::filesystem::path set, out;
  sim::DisturbOptions options;
  bool per_view = false;
};

Result<void> DisturbSet(const DisturbRequest& request, const CommandSession& session) {
  const Execution execution{.stop = session.stop, .num_threads = 1, .report_progress = {}};
  const Result<sim::Studio> studio = ReadStudio(request.set, execution);
  if (!studio) return Fail(studio.error());
  const std::filesystem::path file = request.set / "points.txt";
  const Result<std::string> text = ReadFile(file);
  if (!text) return Fail(text.error());
  const auto parsed = ParsePoints(*text, file.string(), studio->truth.NumViews());
  if (!parsed) return Fail(parsed.error());
  std::vector<sim::VisiblePoint> points;
  for (const ComparePoint& point : *parsed) {
    points.push_back({point.x_in_world, Eigen::Vector3d::Zero(), point.views});
  }
  sim::DisturbOptions options = request.options;
  options.shared_intrinsics = !request.per_view;
  return WriteSimStart(*studio, points, options, request.out);
}

}  // namespace

void AddSimJudgePatchesCommand(CLI::App& sim, CommandSession& session) {
  const auto request = std::make_shared<JudgeRequest>();
  CLI::App* command = sim.add_subcommand("judge-patches", "How far patches lie off the true surface of a rendered set");
  command->add_option("--set", request->set, "Folder that `sim render` wrote")->required();
  command->add_option("--patches", request->patches, "patches.ply")->required();
  command->add_option("--level", request->level, "Pyramid level they were made at")
      ->capture_default_str()
      ->check(CLI::Range(0, kMaxLevel));
  AddThreadsOption(*command, request->num_threads);
  command->callback([request, &session] {
    const Result<void> judged = Judge(*request, session);
    session.exit_status = judged ? kExitAccepted : FailWith("sim judge-patches", judged.error());
  });
}

void AddSimDisturbCommand(CLI::App& sim, CommandSession& session) {
  const auto request = std::make_shared<DisturbRequest>();
  CLI::App* command = sim.add_subcommand("disturb", "One more disturbed start of a rendered set");
  command->add_option("--set", request->set, "Folder that `sim render` wrote")->required();
  command->add_option("--px", request->options.mean_px, "Mean error at the object")->capture_default_str();
  command->add_option("--random-seed", request->options.random_seed)->capture_default_str();
  command->add_flag("--per-view", request->per_view, "Errors of the intrinsics for each view instead of each camera");
  command->add_option("--out", request->out, "Writes OUT_par.txt (and OUT_calibration.json with distortion)")
      ->required();
  command->callback([request, &session] {
    const Result<void> disturbed = DisturbSet(*request, session);
    session.exit_status = disturbed ? kExitAccepted : FailWith("sim disturb", disturbed.error());
  });
}

}  // namespace rigcal
