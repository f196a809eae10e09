#include "core/seed/seed_posterior.h"

#include <algorithm>
#include <cmath>

#include "core/rig/rig_axis.h"
#include "core/rig/rig_model_pose.h"
#include "core/seed/axis_on_board.h"

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

RigEstimate RigOf(const ChartState& state, const ChartColumns& columns, const Eigen::MatrixXd& covariance) {
  const int num_cameras = static_cast<int>(state.cameras.size());
  Derivative rows(RigCovariance::Size(num_cameras), columns.count);
  for (int c = 0; c < num_cameras; ++c) {
    rows.AddEach(RigCovariance::IntrinsicsRow(c), columns.intrinsics[c],
                 Eigen::MatrixXd::Identity(kNumIntrinsics, kNumIntrinsics));
    rows.Add(RigCovariance::MountRow(num_cameras, c), columns.mount[c], Identity6());
  }
  rows.Add(RigCovariance::AnchorRow(num_cameras), columns.anchor, Identity6());
  rows.AddEach(RigCovariance::AxesRow(num_cameras), columns.axes, Eigen::MatrixXd::Identity(9, 9));
  return {state.rig, {}, {rows.Covariance(covariance)}};
}

RigFit FitOf(const ChartTerms& terms, const ChartState& state, const ChartColumns& columns,
             const Eigen::MatrixXd& covariance, const RigEstimate& rig) {
  RigFit fit{.positioner = state.rig.positioner, .stop_errors = state.stop_errors};
  for (std::size_t s = 0; s < terms.stops.size(); ++s) {
    fit.stop_ids.push_back(terms.stops[s].id);
    StopError& sigma = fit.stop_error_sigma.emplace_back(StopError::Zero());
    for (int k = 0; k < kStopErrorSize; ++k) {
      const int column = columns.stop_error[s][k];
      if (column >= 0) sigma[k] = std::sqrt(covariance(column, column));
    }
  }
  fit.axis = AxisOf(rig);
  return fit;
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
  if (!has_rig) return;
  result.calibration.rig = RigOf(state, columns, covariance);
  result.rig = FitOf(terms, state, columns, covariance, *result.calibration.rig);
  result.world_from_board = WorldFromBoard(state.place, terms.board.thickness_m);
  if (result.rig->axis && columns.place >= 0) {
    const Eigen::Matrix4d of_place = covariance.block<kBoardPlaceSize, kBoardPlaceSize>(columns.place, columns.place);
    result.axis_on_board = AxisOnBoardOf(state.place, terms.board.thickness_m, of_place);
  }
}

}  // namespace rigcal
