#include "core/seed/seed_posterior.h"

#include <algorithm>
#include <cmath>

#include "core/rig/rig_model_pose.h"

namespace rigcal {
namespace {

/// d (some rows) / d (everything estimated), filled block by block; blocks that are not estimated have column -1.
class Derivative {
 public:
  Derivative(Eigen::Index rows, int columns) : d_(Eigen::MatrixXd::Zero(rows, columns)) {}
  void Add(Eigen::Index row, int column, const Eigen::MatrixXd& block) {
    if (column >= 0) d_.block(row, column, block.rows(), block.cols()) += block;
  }
  template <std::size_t kSize>
  void AddEach(Eigen::Index row, const std::array<int, kSize>& columns, const Eigen::MatrixXd& block) {
    for (std::size_t k = 0; k < kSize; ++k) Add(row, columns[k], block.col(static_cast<Eigen::Index>(k)));
  }
  [[nodiscard]] Eigen::MatrixXd Covariance(const Eigen::MatrixXd& of_columns) const {
    return d_ * of_columns * d_.transpose();
  }

 private:
  Eigen::MatrixXd d_;
};

Eigen::MatrixXd Identity6() {
  return Eigen::MatrixXd::Identity(6, 6);
}

/// The views of the calibration: with a rig those at its stops, otherwise all that saw the chart.
void ListViews(const SeedScene& scene, const ChartTerms& terms, const ChartState& state, bool has_rig,
               SeedResult& result) {
  for (int v = 0; v < static_cast<int>(terms.views.size()); ++v) {
    const SeedView& known = scene.views[v];
    const bool contradicts = known.stop && !terms.views[v].stop;  // or there is no rig
    const bool seen = !terms.views[v].corners.empty();
    if (has_rig && known.stop && !contradicts && state.rig.cam_from_mount[known.camera]) {
      const StopMotion motion =
          MotionAt(state.rig.positioner, terms.stops[*known.stop], state.stop_errors[*known.stop]);
      result.calibration.views.push_back(
          {known.name, known.camera, CamFromWorld(*state.rig.cam_from_mount[known.camera], motion)});
      result.view_of.push_back(v);
    } else if (!has_rig && seen) {
      result.calibration.views.push_back({known.name, known.camera, state.cam_from_board[v]});
      result.view_of.push_back(v);
    }
  }
}

CalibrationCovariance CovarianceOf(const ChartTerms& terms, const ChartState& state, const ChartColumns& columns,
                                   const Eigen::MatrixXd& covariance, bool has_rig, const SeedResult& result) {
  const int num_cameras = result.calibration.NumCameras();
  const int num_views = result.calibration.NumViews();
  Derivative joint(CalibrationCovariance::PoseRow(num_cameras, num_views), columns.count);
  for (int c = 0; c < num_cameras; ++c) {
    joint.AddEach(CalibrationCovariance::IntrinsicsRow(c), columns.intrinsics[c],
                  Eigen::MatrixXd::Identity(kNumIntrinsics, kNumIntrinsics));
  }
  for (int i = 0; i < num_views; ++i) {
    const int row = CalibrationCovariance::PoseRow(num_cameras, i);
    const int v = result.view_of[i];
    if (!has_rig) {
      joint.Add(row, columns.pose[v], Identity6());
      continue;
    }
    const int camera = terms.views[v].camera, stop = *terms.views[v].stop;
    const RigPose pose =
        RigPoseAt(state.rig.positioner, *state.rig.cam_from_mount[camera], terms.stops[stop], state.stop_errors[stop]);
    joint.Add(row, columns.mount[camera], pose.by_mount);
    joint.AddEach(row, columns.stop_error[stop], pose.by_stop_error);
    joint.Add(row, columns.anchor, pose.by_anchor);
    joint.AddEach(row, columns.axes, pose.by_axes);
  }
  return {joint.Covariance(covariance)};
}

/// Root mean square of the two components across `axis`.
double SigmaAcross(const Eigen::Vector3d& axis, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
  return std::sqrt(std::max(0.0, (across * covariance * across).trace() / 2));
}

std::optional<AxisEstimate> AxisOf(const ChartState& state, const RigEstimate& rig) {
  for (int c = 0; c < static_cast<int>(state.cameras.size()); ++c) {
    if (!state.rig.cam_from_mount[c]) continue;
    const Rigid3d& cam_from_stage = *state.rig.cam_from_mount[c];
    AxisEstimate axis;
    axis.camera = c;
    axis.direction_in_cam = cam_from_stage.rotation * Eigen::Vector3d::UnitZ();
    axis.point_in_cam = cam_from_stage.translation;
    const Eigen::Matrix<double, 6, 6> covariance = rig.covariance.block<6, 6>(6 * c, 6 * c);
    // direction' = direction + w x direction; point' = point + w x point + dt
    axis.direction_sigma_rad = SigmaAcross(axis.direction_in_cam, covariance.topLeftCorner<3, 3>());
    Eigen::Matrix<double, 3, 6> by_disturbance;
    by_disturbance << -Skew(axis.point_in_cam), Eigen::Matrix3d::Identity();
    axis.point_sigma_m = SigmaAcross(axis.direction_in_cam, by_disturbance * covariance * by_disturbance.transpose());
    return axis;
  }
  return std::nullopt;
}

RigEstimate RigOf(const ChartTerms& terms, const ChartState& state, const ChartColumns& columns,
                  const Eigen::MatrixXd& covariance) {
  RigEstimate rig;
  rig.model = state.rig;
  rig.stop_errors = state.stop_errors;
  rig.world_from_board = WorldFromBoard(state.place, terms.board.thickness_m);
  for (std::size_t s = 0; s < terms.stops.size(); ++s) {
    StopError& sigma = rig.stop_error_sigma.emplace_back(StopError::Zero());
    for (int k = 0; k < kStopErrorSize; ++k) {
      const int column = columns.stop_error[s][k];
      if (column >= 0) sigma[k] = std::sqrt(covariance(column, column));
    }
  }
  const int num_cameras = static_cast<int>(state.cameras.size());
  Derivative geometry(6 * num_cameras + 6 + 9, columns.count);
  for (int c = 0; c < num_cameras; ++c) geometry.Add(6 * c, columns.mount[c], Identity6());
  geometry.Add(6 * num_cameras, columns.anchor, Identity6());
  geometry.AddEach(6 * num_cameras + 6, columns.axes, Eigen::MatrixXd::Identity(9, 9));
  rig.covariance = geometry.Covariance(covariance);
  if (rig.model.positioner.kind == PositionerKind::kTurntable) rig.axis = AxisOf(state, rig);
  return rig;
}

}  // namespace

void WriteSolution(const SeedScene& scene, const ChartTerms& terms, const ChartState& state,
                   const ChartColumns& columns, const Eigen::MatrixXd& covariance, SeedResult& result) {
  const bool has_rig =
      !state.rig.cam_from_mount.empty() && std::any_of(state.rig.cam_from_mount.begin(), state.rig.cam_from_mount.end(),
                                                       [](const auto& mount) { return mount.has_value(); });
  result.calibration.cameras = state.cameras;
  result.calibration.unit = LengthUnit::kMetre;
  ListViews(scene, terms, state, has_rig, result);
  result.calibration.covariance = CovarianceOf(terms, state, columns, covariance, has_rig, result);
  for (int v = 0; v < static_cast<int>(terms.views.size()); ++v) {
    if (columns.pose[v] < 0) continue;
    result.hand_held.push_back({v, state.cam_from_board[v], covariance.block<6, 6>(columns.pose[v], columns.pose[v])});
  }
  const auto shape_sigma = [&](int k) { return std::sqrt(covariance(columns.shape + k, columns.shape + k)); };
  result.board_shape = state.shape;
  result.board_shape_sigma = {shape_sigma(0), shape_sigma(1), shape_sigma(2)};
  if (has_rig) result.rig = RigOf(terms, state, columns, covariance);
}

}  // namespace rigcal
