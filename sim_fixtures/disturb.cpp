#include "sim_fixtures/disturb.h"

#include <algorithm>
#include <cmath>

#include "core/base/ensure.h"
#include "core/base/random.h"

namespace rigcal::sim {
namespace {

/// fx fy cx cy, rotation vector, translation.
constexpr int kNumParameters = 10;
using Parameters = Eigen::Matrix<double, kNumParameters, 1>;

void Apply(const Parameters& change, Camera& camera, Rigid3d& cam_from_world) {
  camera.fx_px += change[0];
  camera.fy_px += change[1];
  camera.cx_px += change[2];
  camera.cy_px += change[3];
  cam_from_world = Disturbed(cam_from_world, change.tail<6>());
}

/// Points seen by each view.
std::vector<std::vector<Eigen::Vector3d>> PointsOfViews(int num_views, const std::vector<VisiblePoint>& points) {
  std::vector<std::vector<Eigen::Vector3d>> of_view(num_views);
  for (const VisiblePoint& point : points) {
    for (const int view : point.views) of_view[view].push_back(point.x_in_world);
  }
  return of_view;
}

/// How much of one parameter moves a view's points by one pixel RMS.
double StepForOnePixel(const Camera& camera, const Rigid3d& cam_from_world, const std::vector<Eigen::Vector3d>& points,
                       int parameter) {
  const double step = parameter < 4 ? 1.0 : 1e-4;  // px; rad or metres
  Parameters change = Parameters::Zero();
  change[parameter] = step;
  Camera moved = camera;
  Rigid3d moved_pose = cam_from_world;
  Apply(change, moved, moved_pose);
  double sum = 0;
  for (const Eigen::Vector3d& x : points) {
    sum += (*Project(moved, moved_pose * x) - *Project(camera, cam_from_world * x)).squaredNorm();
  }
  return step / std::sqrt(sum / static_cast<double>(points.size()));
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

Parameters SigmaForOnePixel(const RigCalibration& truth, const std::vector<std::vector<Eigen::Vector3d>>& points) {
  Parameters sigma;
  for (int parameter = 0; parameter < kNumParameters; ++parameter) {
    std::vector<double> of_views;
    for (int view = 0; view < truth.NumViews(); ++view) {
      if (points[view].empty()) continue;
      of_views.push_back(
          StepForOnePixel(truth.CameraOf(view), truth.views[view].cam_from_world, points[view], parameter));
    }
    sigma[parameter] = Median(of_views);
  }
  return sigma;
}

/// The normal errors of every view, already times sigma.
std::vector<Parameters> DrawChanges(const RigCalibration& truth, const Parameters& sigma,
                                    const DisturbOptions& options) {
  std::vector<Parameters> changes(truth.NumViews());
  for (int view = 0; view < truth.NumViews(); ++view) {
    Random random(DeriveSeed(options.random_seed, static_cast<std::uint64_t>(view)));
    for (int i = 0; i < kNumParameters; ++i) changes[view][i] = random.Normal() * sigma[i];
    if (options.shared_intrinsics) {
      const auto first = std::find_if(truth.views.begin(), truth.views.end(),
                                      [&](const View& other) { return other.camera == truth.views[view].camera; });
      changes[view].head<4>() = changes[first - truth.views.begin()].head<4>();
    }
    const Camera& camera = truth.CameraOf(view);
    changes[view][1] = changes[view][0] * camera.fy_px / camera.fx_px;
  }
  return changes;
}

RigCalibration Changed(const RigCalibration& truth, const std::vector<Parameters>& changes, double factor,
                       bool shared_intrinsics) {
  RigCalibration out = truth;
  if (!shared_intrinsics) out.cameras.clear();
  for (int view = 0; view < truth.NumViews(); ++view) {
    Camera camera = truth.CameraOf(view);
    Apply(factor * changes[view], camera, out.views[view].cam_from_world);
    if (shared_intrinsics) {
      out.cameras[truth.views[view].camera] = camera;
    } else {
      camera.id += fmt::format("#{}", view);
      out.cameras.push_back(camera);
      out.views[view].camera = view;
    }
  }
  return out;
}

}  // namespace

double MeanDisplacement_px(const RigCalibration& a, const RigCalibration& b, const std::vector<VisiblePoint>& points) {
  double sum = 0;
  std::size_t count = 0;
  for (const VisiblePoint& point : points) {
    for (const int view : point.views) {
      const auto in_a = Project(a.CameraOf(view), a.views[view].cam_from_world * point.x_in_world);
      const auto in_b = Project(b.CameraOf(view), b.views[view].cam_from_world * point.x_in_world);
      Ensure(in_a && in_b, "the points stay in front of the cameras");
      sum += (*in_a - *in_b).norm();
      ++count;
    }
  }
  Ensure(count > 0, "at least one point is seen");
  return sum / static_cast<double>(count);
}

RigCalibration Disturb(const RigCalibration& truth, const std::vector<VisiblePoint>& points,
                       const DisturbOptions& options) {
  const Parameters sigma = SigmaForOnePixel(truth, PointsOfViews(truth.NumViews(), points));
  const std::vector<Parameters> changes = DrawChanges(truth, sigma, options);
  constexpr int kIterations = 30;  // the displacement is almost proportional to the factor
  // A first factor of one pixel times the target overshoots by the number of parameters: it stays in front of cameras.
  double factor = options.mean_px / kNumParameters;
  for (int i = 0; i < kIterations; ++i) {
    const RigCalibration candidate = Changed(truth, changes, factor, options.shared_intrinsics);
    factor *= options.mean_px / MeanDisplacement_px(truth, candidate, points);
  }
  return Changed(truth, changes, factor, options.shared_intrinsics);
}

}  // namespace rigcal::sim
