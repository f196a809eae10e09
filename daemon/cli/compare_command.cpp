#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "config/json_text.h"
#include "config/load_cameras.h"
#include "config/points_file.h"
#include "config/read_file.h"
#include "core/validate/compare.h"
#include "daemon/cli/command.h"

namespace rigcal {
namespace {

struct CompareArguments {
  std::filesystem::path reference, estimate, points;
  bool projective = false, json = false;
};

struct Comparison {
  CompareReport similarity;
  std::optional<CompareReport> projectivity;
  int num_reference_views = 0;
  std::vector<std::string> view_names;  ///< that both have, in the order of view_mean_px
};

/// A Middlebury file tells no image size: the one that has the principal point at its centre decides which part of the
/// volume is looked at. Nothing else depends on it.
void AssumeCentredPictures(RigCalibration& calibration) {
  for (Camera& camera : calibration.cameras) {
    if (camera.width_px > 0 && camera.height_px > 0) continue;
    camera.width_px = std::max(1, static_cast<int>(std::lround(std::min(2 * camera.cx_px + 1, 1e6))));
    camera.height_px = std::max(1, static_cast<int>(std::lround(std::min(2 * camera.cy_px + 1, 1e6))));
  }
}

Result<std::vector<ComparePoint>> Points(const CompareArguments& arguments, RigCalibration& reference) {
  if (arguments.points.empty()) {
    AssumeCentredPictures(reference);
    return SpreadPoints(reference);
  }
  const Result<std::string> text = ReadFile(arguments.points);
  if (!text) return Fail(text.error());
  return ParsePoints(*text, arguments.points.string(), reference.NumViews());
}

Result<Comparison> Compare(const CompareArguments& arguments) {
  Result<LoadedCameras> reference = LoadCamerasUnchanged(arguments.reference);
  if (!reference) return Fail(reference.error());
  const Result<LoadedCameras> estimate = LoadCamerasUnchanged(arguments.estimate);
  if (!estimate) return Fail(estimate.error());
  const auto points = Points(arguments, reference->calibration);
  if (!points) return Fail(points.error());
  Comparison comparison;
  comparison.num_reference_views = reference->calibration.NumViews();
  for (const View& view : reference->calibration.views)
    for (const View& other : estimate->calibration.views)
      if (other.name == view.name) comparison.view_names.push_back(view.name);
  const auto compare = [&](CompareAlignment alignment) {
    return CompareCameras(reference->calibration, estimate->calibration, *points, alignment);
  };
  const Result<CompareReport> similarity = compare(CompareAlignment::kSimilarity);
  if (!similarity) return Fail(similarity.error());
  comparison.similarity = *similarity;
  if (!arguments.projective) return comparison;
  const Result<CompareReport> projectivity = compare(CompareAlignment::kProjectivity);
  if (!projectivity) return Fail(projectivity.error());
  comparison.projectivity = *projectivity;
  return comparison;
}

nlohmann::ordered_json DistancesJson(const CompareReport& report) {
  return {{"mean_px", report.mean_px},
          {"median_px", report.median_px},
          {"rms_px", report.rms_px},
          {"p95_px", report.p95_px},
          {"max_px", report.max_px}};
}

std::string ComparisonJson(const Comparison& comparison) {
  const CompareReport& report = comparison.similarity;
  nlohmann::ordered_json json = {{"num_views", report.num_views},
                                 {"num_reference_views", comparison.num_reference_views}};
  json.update(DistancesJson(report));
  json["rotation_mean_deg"] = report.rotation_mean_deg;
  json["rotation_max_deg"] = report.rotation_max_deg;
  json["centre_relative"] = report.centre_relative;
  json["focal_relative"] = report.focal_relative;
  json["views"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < report.view_mean_px.size(); ++i)
    json["views"].push_back({{"name", comparison.view_names[i]}, {"mean_px", report.view_mean_px[i]}});
  if (comparison.projectivity) json["projective"] = DistancesJson(*comparison.projectivity);
  return JsonText(json);
}

std::string ComparisonTable(const Comparison& comparison) {
  const CompareReport& report = comparison.similarity;
  std::string text =
      fmt::format("{} of {} reference views compared\n", report.num_views, comparison.num_reference_views);
  text += fmt::format("{:24} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "pixels after the best", "mean", "median", "rms", "p95",
                      "max");
  const auto row = [&text](const char* name, const CompareReport& r) {
    text += fmt::format("{:24} {:8.3f} {:8.3f} {:8.3f} {:8.3f} {:8.3f}\n", name, r.mean_px, r.median_px, r.rms_px,
                        r.p95_px, r.max_px);
  };
  row("similarity", report);
  if (comparison.projectivity) row("projectivity", *comparison.projectivity);
  text +=
      fmt::format("rotation {:.4f} deg (max {:.4f}), centres {:.3g} of their distance, focal length {:.3g} of itself\n",
                  report.rotation_mean_deg, report.rotation_max_deg, report.centre_relative, report.focal_relative);
  for (std::size_t i = 0; i < report.view_mean_px.size(); ++i)
    text += fmt::format("  {:22} {:8.3f}\n", comparison.view_names[i], report.view_mean_px[i]);
  return text;
}

int RunCompare(const CompareArguments& arguments) {
  const Result<Comparison> comparison = Compare(arguments);
  if (!comparison) return FailWith("compare", comparison.error());
  fmt::print("{}", arguments.json ? ComparisonJson(*comparison) : ComparisonTable(*comparison));
  return kExitAccepted;
}

}  // namespace

void AddCompareCommand(CLI::App& app, CommandSession& session) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand("compare", "How many pixels cameras are off from reference cameras");
  command->add_option("--reference", arguments->reference, "Reference cameras")->required();
  command->add_option("--estimate", arguments->estimate, "Cameras to judge")->required();
  command->add_option(
      "--points", arguments->points,
      "Object points, lines 'x y z [k v1 .. vk]'; default: spread over the volume that two views share");
  command->add_flag("--projective", arguments->projective, "Also after the best projectivity");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, &session] { session.exit_status = RunCompare(*arguments); });
}

}  // namespace rigcal
