#include "core/validate/metric_refit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/rig/camera_information.h"
#include "core/rig/free_parameters.h"
#include "core/rig/measurements.h"
#include "core/rig/reprojection.h"
#include "core/rig/seed_anchors.h"
#include "core/validate/evidence.h"

namespace rigcal {
namespace {

/// How far the cameras may go for one sigma where features say nothing: root mean square over the object's points.
/// The seed prior of DESIGN.md section 3 (6 px on 12 points in each of 16 views) comes to 0.43.
constexpr double kFreedomPx = 0.5;
constexpr int kAnchorsPerView = 12;
constexpr double kMinSigmaPx = 0.1;    ///< no feature is located better
constexpr double kCauchySigmas = 2.4;  ///< 95 % efficiency on pure noise
constexpr int kScaleRounds = 3;        ///< the residuals' scale falls as the cameras come right
constexpr int kStepsPerRound = 8;
constexpr double kMinCostDecrease = 1e-4;  ///< relative; a smaller step ends a round

struct Problem {
  std::vector<SeedAnchor> anchors;
  double anchor_sigma_px = 1;
  std::vector<CameraPrior> priors;  ///< per merged camera
  double sigma_px = 1;              ///< of one coordinate of a feature
};

struct State {
  RigCalibration calibration;
  MeasurementSet measurements;  ///< whitening: 1 / sigma times the square root of the robust weight
  double cost = std::numeric_limits<double>::infinity();
};

/// One set of intrinsics (the median, no skew) for each physical camera. Each view is turned and moved along its ray so
/// that the middle of the object stays at its pixel, in its size.
RigCalibration Merged(const RigCalibration& judged, const Eigen::Vector3d& object_in_world) {
  const std::vector<int> physical = PhysicalCameras(judged);
  RigCalibration merged;
  merged.unit = judged.unit;
  merged.cameras.resize(*std::max_element(physical.begin(), physical.end()) + 1);
  for (int m = 0; m < merged.NumCameras(); ++m) {
    std::array<std::vector<double>, kNumIntrinsics> values;
    for (int c = 0; c < judged.NumCameras(); ++c) {
      if (physical[c] != m) continue;
      if (values[0].empty()) merged.cameras[m] = judged.cameras[c];
      for (int k = 0; k < kNumIntrinsics; ++k) values[k].push_back(judged.cameras[c].Intrinsics()[k]);
    }
    IntrinsicVector median;
    for (int k = 0; k < kNumIntrinsics; ++k) median[k] = Median(values[k]);
    median[kSkew] = 0;
    merged.cameras[m].SetIntrinsics(median);
  }
  for (View view : judged.views) {
    const Camera& old_camera = judged.cameras[view.camera];
    view.camera = physical[view.camera];
    const Camera& camera = merged.cameras[view.camera];
    const Eigen::Vector3d x_in_cam = view.cam_from_world * object_in_world;
    const auto x_px = Project(old_camera, x_in_cam);
    const auto ray = x_px ? RayInCam(camera, *x_px) : std::nullopt;
    if (ray && old_camera.Intrinsics() != camera.Intrinsics()) {
      const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(x_in_cam, *ray);
      const double stretch = std::sqrt(camera.fx_px * camera.fy_px / (old_camera.fx_px * old_camera.fy_px));
      view.cam_from_world.rotation = (turn * view.cam_from_world.rotation).normalized();
      view.cam_from_world.translation = stretch * (turn * x_in_cam) - view.cam_from_world.rotation * object_in_world;
    }
    merged.views.push_back(view);
  }
  return merged;
}

/// Gauss-Newton on each point by its weighted features.
void ResolvePoints(State* state) {
  constexpr int kSteps = 2;
  auto& set = state->measurements;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<Eigen::Matrix3d> h(set.x_in_world.size(), Eigen::Matrix3d::Zero());
    std::vector<Eigen::Vector3d> g(set.x_in_world.size(), Eigen::Vector3d::Zero());
    for (const Measurement& m : set.items) {
      const View& view = state->calibration.views[m.view];
      const auto seen =
          Reproject(state->calibration.cameras[view.camera], view.cam_from_world, set.x_in_world[m.point]);
      if (!seen) continue;
      const Eigen::Matrix<double, 2, 3> j = m.whitening * seen->by_point;
      h[m.point] += j.transpose() * j;
      g[m.point] += j.transpose() * (m.whitening * (seen->x_px - m.x_px));
    }
    for (std::size_t p = 0; p < h.size(); ++p) {
      const Eigen::Vector3d moved = set.x_in_world[p] - h[p].ldlt().solve(g[p]);
      if (moved.allFinite()) set.x_in_world[p] = moved;
    }
  }
}

/// Sets robust weights and cost from the residuals; returns the residuals' lengths.
std::vector<double> Weigh(const Problem& problem, State* state) {
  const double cauchy_px = kCauchySigmas * problem.sigma_px;
  const double behind_px = 100 * cauchy_px;  // a point behind its camera costs like a gross outlier
  std::vector<double> lengths;
  state->cost = 0;
  for (Measurement& m : state->measurements.items) {
    const View& view = state->calibration.views[m.view];
    const auto x_px =
        Project(state->calibration.cameras[view.camera], view.cam_from_world * state->measurements.x_in_world[m.point]);
    const double r = x_px ? std::min((*x_px - m.x_px).norm(), behind_px) : behind_px;
    const double relative2 = r * r / (cauchy_px * cauchy_px);
    m.whitening = Eigen::Matrix2d::Identity() / (problem.sigma_px * std::sqrt(1 + relative2));
    state->cost += kCauchySigmas * kCauchySigmas * std::log1p(relative2);
    lengths.push_back(r);
  }
  for (const SeedAnchor& a : problem.anchors) {
    const View& view = state->calibration.views[a.view];
    const auto x_px = Project(state->calibration.cameras[view.camera], view.cam_from_world * a.x_in_world);
    if (!x_px) {
      state->cost = std::numeric_limits<double>::infinity();
      return lengths;
    }
    state->cost += (*x_px - a.seed_px).squaredNorm() / (problem.anchor_sigma_px * problem.anchor_sigma_px);
  }
  for (int c = 0; c < state->calibration.NumCameras(); ++c) {
    const Camera& camera = state->calibration.cameras[c];
    const double off = (camera.fx_px / camera.fy_px - problem.priors[c].aspect) / problem.priors[c].aspect_sigma;
    state->cost += off * off;
  }
  return lengths;
}

/// Half the gradient and the Gauss-Newton matrix of the cost, points eliminated (they lie at their optimum).
struct NormalEquations {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
};

void AddGradient(const FreeRows& rows, int camera, int view, const Reprojection& seen, const Eigen::Vector2d& weighted,
                 Eigen::VectorXd* g) {
  for (int k = 0; k < kNumIntrinsics; ++k) {
    if (rows.intrinsics[camera][k] >= 0) (*g)[rows.intrinsics[camera][k]] += seen.by_intrinsics.col(k).dot(weighted);
  }
  g->segment<6>(rows.pose[view]) += seen.by_pose.transpose() * weighted;
}

NormalEquations Linearised(const Problem& problem, const State& state, const FreeParameters& free) {
  const FreeRows rows = RowsOf(free);
  const RigCalibration& calibration = state.calibration;
  NormalEquations n{FeatureInformation(calibration, free, state.measurements) +
                        SeedInformation(calibration, free, problem.anchors, problem.anchor_sigma_px),
                    Eigen::VectorXd::Zero(rows.count)};
  for (const Measurement& m : state.measurements.items) {
    const int camera = calibration.views[m.view].camera;
    const auto seen = Reproject(calibration.cameras[camera], calibration.views[m.view].cam_from_world,
                                state.measurements.x_in_world[m.point]);
    if (!seen) continue;
    AddGradient(rows, camera, m.view, *seen, m.whitening.transpose() * m.whitening * (seen->x_px - m.x_px), &n.g);
  }
  for (const SeedAnchor& a : problem.anchors) {
    const int camera = calibration.views[a.view].camera;
    const auto seen = Reproject(calibration.cameras[camera], calibration.views[a.view].cam_from_world, a.x_in_world);
    if (!seen) continue;
    const double weight = 1 / (problem.anchor_sigma_px * problem.anchor_sigma_px);
    AddGradient(rows, camera, a.view, *seen, weight * (seen->x_px - a.seed_px), &n.g);
  }
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    const Camera& camera = calibration.cameras[c];
    const CameraPrior& prior = problem.priors[c];
    const double aspect = camera.fx_px / camera.fy_px;
    const int fx = rows.intrinsics[c][kFx], fy = rows.intrinsics[c][kFy];
    const Eigen::Vector2d j = Eigen::Vector2d(1, -aspect) / (camera.fy_px * prior.aspect_sigma);
    const std::array<int, 2> at{fx, fy};
    n.h(at, at) += j * j.transpose();
    n.g(at) += j * ((aspect - prior.aspect) / prior.aspect_sigma);
  }
  return n;
}

void Apply(const FreeRows& rows, const Eigen::VectorXd& step, RigCalibration* calibration) {
  for (int c = 0; c < calibration->NumCameras(); ++c) {
    IntrinsicVector intrinsics = calibration->cameras[c].Intrinsics();
    for (int k = 0; k < kNumIntrinsics; ++k) {
      if (rows.intrinsics[c][k] >= 0) intrinsics[k] += step[rows.intrinsics[c][k]];
    }
    calibration->cameras[c].SetIntrinsics(intrinsics);
  }
  for (int v = 0; v < calibration->NumViews(); ++v) {
    calibration->views[v].cam_from_world =
        Disturbed(calibration->views[v].cam_from_world, step.segment<6>(rows.pose[v]));
  }
}

/// One damped step that lowers the cost; false when none does any more.
bool Step(const Problem& problem, const FreeParameters& free, double* damping, State* state) {
  constexpr int kTries = 6;
  constexpr double kDampingFactor = 10;
  const FreeRows rows = RowsOf(free);
  const NormalEquations n = Linearised(problem, *state, free);
  for (int attempt = 0; attempt < kTries; ++attempt) {
    Eigen::MatrixXd damped = n.h;
    damped.diagonal() *= 1 + *damping;
    State next = *state;
    Apply(rows, -damped.ldlt().solve(n.g), &next.calibration);
    ResolvePoints(&next);
    Weigh(problem, &next);
    if (std::isfinite(next.cost) && next.cost < state->cost) {
      const bool worthwhile = state->cost - next.cost > kMinCostDecrease * state->cost;
      *state = std::move(next);
      *damping /= kDampingFactor;
      return worthwhile;
    }
    *damping *= kDampingFactor;
  }
  return false;
}

Problem MakeProblem(const RigCalibration& judged, const TrackSet& tracks, std::span<const CameraPrior> camera_priors) {
  Problem problem;
  SeedPrior as_seed;
  as_seed.seed = judged;
  as_seed.points_per_view = kAnchorsPerView;
  problem.anchors = ChooseSeedAnchors(as_seed, tracks);
  problem.anchor_sigma_px =
      kFreedomPx * std::sqrt(static_cast<double>(std::max<std::size_t>(1, problem.anchors.size())));
  const std::vector<int> physical = PhysicalCameras(judged);
  problem.priors.resize(*std::max_element(physical.begin(), physical.end()) + 1);
  for (std::size_t c = physical.size(); c-- > 0;) problem.priors[physical[c]] = camera_priors[c];
  return problem;
}

}  // namespace

Result<RigCalibration> RefitAsMetric(const RigCalibration& judged, const std::vector<Track>& tracks,
                                     std::span<const CameraPrior> camera_priors, const Execution& execution) {
  TrackSet set;
  std::vector<double> coordinates[3];
  for (Track track : tracks) {
    const auto x_in_world = TriangulateTrack(judged, track);
    if (!x_in_world) continue;
    track.x_in_world = *x_in_world;
    track.held_out = false;
    for (int k = 0; k < 3; ++k) coordinates[k].push_back(x_in_world->operator[](k));
    set.tracks.push_back(std::move(track));
  }
  const Eigen::Vector3d object(Median(coordinates[0]), Median(coordinates[1]), Median(coordinates[2]));
  Problem problem = MakeProblem(judged, set, camera_priors);
  State state;
  state.calibration = Merged(judged, object);
  state.measurements = MeasurementsOf(state.calibration, set, {});
  const FreeParameters free = AllPinholeParameters(state.calibration);
  constexpr double kMedianOfRayleigh = 1.1774;  // median length of a 2-D residual in sigmas of one coordinate
  for (int round = 0; round < kScaleRounds; ++round) {
    problem.sigma_px = std::max(kMinSigmaPx, Median(Weigh(problem, &state)) / kMedianOfRayleigh);
    ResolvePoints(&state);
    problem.sigma_px = std::max(kMinSigmaPx, Median(Weigh(problem, &state)) / kMedianOfRayleigh);
    Weigh(problem, &state);
    double damping = 1e-4;
    for (int step = 0; step < kStepsPerRound; ++step) {
      if (execution.Stopped()) return Cancelled("validation");
      if (!Step(problem, free, &damping, &state)) break;
    }
  }
  return state.calibration;
}

}  // namespace rigcal
