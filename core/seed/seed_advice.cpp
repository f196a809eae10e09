#include "core/seed/seed_advice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/joined.h"

namespace rigcal {
namespace {

constexpr int kCells = 10;  ///< the picture is divided into kCells x kCells for its coverage
/// Width of the rim, in shares of the picture, whose corners and edges are named when nothing was seen there:
/// distortion is strongest in it and extrapolated when nothing is seen.
constexpr double kRimShare = 0.2;
/// Tilt that tells focal length from distance: at 20 degrees the board's far edge is seen 1/3 of its size further away.
constexpr double kLeastTilt_rad = 20 * std::numbers::pi / 180;
constexpr int kAdvisedViews = 10;
/// Focal length is asked to be better than this before an object is scanned (issue 3: 0.05 % of a full set).
constexpr double kAdvisedFocalSigma = 1e-3;

constexpr std::array<const char*, 9> kZoneNames = {"upper left corner", "upper edge", "upper right corner",
                                                   "left edge",         "middle",     "right edge",
                                                   "lower left corner", "lower edge", "lower right corner"};

int ZoneOf(double share) {
  return share < kRimShare ? 0 : share < 1 - kRimShare ? 1 : 2;
}

std::vector<std::string> UnseenZones(const SeedScene& scene, const ChartTerms& terms, int camera) {
  std::array<bool, 9> seen = {};
  for (const ChartView& view : terms.views) {
    if (view.camera != camera) continue;
    for (const ChartCorner& corner : view.corners) {
      const int column = ZoneOf((corner.x_px.x() + 0.5) / scene.cameras[camera].width_px);
      const int row = ZoneOf((corner.x_px.y() + 0.5) / scene.cameras[camera].height_px);
      seen[3 * row + column] = true;
    }
  }
  std::vector<std::string> unseen;
  for (std::size_t zone = 0; zone < seen.size(); ++zone) {
    if (!seen[zone]) unseen.emplace_back(kZoneNames[zone]);
  }
  return unseen;
}

double FocalSigma(const Camera& camera, int column, const Eigen::MatrixXd& covariance) {
  return std::sqrt(covariance(column, column)) / camera.fx_px;
}

}  // namespace

void ReportCoverage(const SeedScene& scene, const ChartTerms& terms, const ChartState& state, SeedReport& report) {
  for (int c = 0; c < static_cast<int>(scene.cameras.size()); ++c) {
    std::array<bool, kCells* kCells> hit = {};
    SeedCameraReport& camera = report.cameras[c];
    for (int v = 0; v < static_cast<int>(terms.views.size()); ++v) {
      const ChartView& view = terms.views[v];
      if (view.camera != c || view.corners.empty()) continue;
      for (const ChartCorner& corner : view.corners) {
        const auto cell = [](double x_px, int size_px) {
          return std::clamp(static_cast<int>(kCells * (x_px + 0.5) / size_px), 0, kCells - 1);
        };
        hit[kCells * cell(corner.x_px.y(), scene.cameras[c].height_px) +
            cell(corner.x_px.x(), scene.cameras[c].width_px)] = true;
      }
      const Rigid3d pose = CamFromBoard(terms, state, v);
      const Eigen::Vector3d normal_in_cam = pose.rotation * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d sight_in_cam = -(pose * CentreInBoard(terms.board)).normalized();
      camera.max_tilt_rad =
          std::max(camera.max_tilt_rad, std::acos(std::clamp(normal_in_cam.dot(sight_in_cam), -1.0, 1.0)));
    }
    camera.coverage = static_cast<double>(std::count(hit.begin(), hit.end(), true)) / (kCells * kCells);
  }
}

std::vector<std::string> Advise(const SeedScene& scene, const ChartTerms& terms, const ChartState& state,
                                const ChartColumns& columns, const Eigen::MatrixXd& covariance,
                                const SeedReport& report) {
  std::vector<std::string> advice;
  const bool has_rig = !state.rig.cam_from_mount.empty() && scene.rig.has_value();
  for (int c = 0; c < static_cast<int>(scene.cameras.size()); ++c) {
    std::vector<std::string> lacks;
    const SeedCameraReport& camera = report.cameras[c];
    const std::vector<std::string> unseen = UnseenZones(scene, terms, c);
    const double focal_sigma = FocalSigma(state.cameras[c], columns.intrinsics[c][kFx], covariance);
    if (!unseen.empty()) lacks.push_back(fmt::format("{} unseen: move the board there", Joined(unseen, ", ")));
    if (camera.max_tilt_rad < kLeastTilt_rad) lacks.emplace_back("tilt the board");
    if (camera.num_views < kAdvisedViews) {
      lacks.push_back(
          fmt::format("show more positions of the board ({} seen, {} advised)", camera.num_views, kAdvisedViews));
    }
    if (focal_sigma > kAdvisedFocalSigma) {
      lacks.push_back(fmt::format("focal length known to {:.2f} % only: tilt the board more, and show it closer",
                                  100 * focal_sigma));
    }
    if (has_rig && !state.rig.cam_from_mount[c]) {
      lacks.emplace_back("never saw the chart at a stop: its place in the rig is unknown");
    }
    if (!lacks.empty()) advice.push_back(fmt::format("camera {}: {}", scene.cameras[c].id, Joined(lacks, "; ")));
  }
  return advice;
}

}  // namespace rigcal
