#include "core/seed/start_rig.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "core/base/median.h"
#include "core/rig/rig_model_pose.h"

namespace rigcal {
namespace {

/// Below this, two angles or poses are the same stop for the purpose of finding an axis: 1 degree, 1 mm.
constexpr double kLeastTurn_rad = 0.017;
constexpr double kLeastShift_m = 1e-3;

/// What one camera saw at the stops.
struct StopSightings {
  int camera = 0;
  std::vector<int> views;
};

std::vector<StopSightings> SightingsByCamera(const ChartTerms& terms, int num_cameras) {
  std::vector<StopSightings> all(num_cameras);
  for (int c = 0; c < num_cameras; ++c) all[c].camera = c;
  for (int v = 0; v < static_cast<int>(terms.views.size()); ++v) {
    if (terms.views[v].stop && !terms.views[v].corners.empty()) all[terms.views[v].camera].views.push_back(v);
  }
  return all;
}

/// How far two poses of the board are apart, seen at the board: a length.
double PoseGap(const Board& board, const Rigid3d& a, const Rigid3d& b) {
  const Eigen::Vector3d centre = CentreInBoard(board);
  return (a * centre - b * centre).norm() + a.rotation.angularDistance(b.rotation) * centre.norm();
}

/// The candidate whose predictions of cam_from_board have the smallest median gap.
template <typename Predict>
int BestCandidate(const ChartTerms& terms, const ChartState& state, const std::vector<int>& views,
                  const Predict& predict) {
  int best = 0;
  double best_gap = HUGE_VAL;
  for (int i = 0; i < static_cast<int>(views.size()); ++i) {
    std::vector<double> gaps;
    for (const int v : views) gaps.push_back(PoseGap(terms.board, predict(views[i], v), state.cam_from_board[v]));
    const double gap = Median(std::move(gaps));
    if (gap < best_gap) best_gap = gap, best = i;
  }
  return best;
}

Rigid3d MountFromWorldAt(const ChartTerms& terms, const Positioner& positioner, int view) {
  return CamFromWorld(Rigid3d{}, MotionAt(positioner, terms.stops[*terms.views[view].stop], StopError::Zero()));
}

/// Direction and a point of the axis in the camera, then how the board lies on the table.
Result<void> StartTurntable(const ChartTerms& terms, const StopSightings& seen, ChartState& state) {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  const auto turn = [&](int from, int to) {
    return terms.stops[*terms.views[to].stop].axes[0] - terms.stops[*terms.views[from].stop].axes[0];
  };
  for (const int a : seen.views) {
    for (const int b : seen.views) {
      const Eigen::Matrix3d r =
          (state.cam_from_board[b].rotation * state.cam_from_board[a].rotation.conjugate()).toRotationMatrix();
      const double sine = std::sin(turn(a, b));  // vee(R - R^T) = 2 sin(angle) axis
      axis += sine * Eigen::Vector3d(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
    }
  }
  if (axis.norm() < kLeastTurn_rad) {
    return Fail(ErrorCode::kBadInput,
                "the chart was seen at {} stops whose angles do not determine the turntable's axis: show it at three "
                "or more angles",
                seen.views.size());
  }
  axis.normalize();
  // q_b = R q_a + (I - R) o for the board's centre q: least squares for o, the axis direction itself being free.
  Eigen::Matrix3d normal = axis * axis.transpose();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const int a : seen.views) {
    for (const int b : seen.views) {
      const Eigen::Matrix3d r = ExpRotation(turn(a, b) * axis).toRotationMatrix();
      const Eigen::Matrix3d i_minus_r = Eigen::Matrix3d::Identity() - r;
      const Eigen::Vector3d centre = CentreInBoard(terms.board);
      normal += i_minus_r.transpose() * i_minus_r;
      right += i_minus_r.transpose() * (state.cam_from_board[b] * centre - r * (state.cam_from_board[a] * centre));
    }
  }
  const Eigen::Vector3d point = normal.ldlt().solve(right);
  // A stage frame on the axis, then turned and shifted along it until the board's place has the form of BoardPlace.
  const Rigid3d cam_from_axis{Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis), point};
  const auto board_from = [&](int v) {
    const double angle = terms.stops[*terms.views[v].stop].axes[0];
    return Rigid3d{ExpRotation({0, 0, -angle}), Eigen::Vector3d::Zero()} * cam_from_axis.Inverse() *
           state.cam_from_board[v];
  };
  const int best = BestCandidate(terms, state, seen.views, [&](int candidate, int v) {
    const double angle = terms.stops[*terms.views[v].stop].axes[0];
    return cam_from_axis * Rigid3d{ExpRotation({0, 0, angle}), Eigen::Vector3d::Zero()} * board_from(candidate);
  });
  const Rigid3d axis_from_board = board_from(seen.views[best]);
  const Eigen::Quaterniond& q = axis_from_board.rotation;
  const Eigen::Quaterniond twist = Eigen::Quaterniond(q.w(), 0, 0, q.z()).normalized();  // q = twist about z * tilt
  const Eigen::Vector3d tilt = LogRotation(twist.conjugate() * q);
  const Eigen::Vector3d origin = twist.conjugate() * axis_from_board.translation;
  state.place = {tilt.x(), tilt.y(), origin.x(), origin.y()};
  return {};
}

/// cam_from_world.t = t0 + sum of R axis_k p_k over the stops: linear least squares.
Result<void> StartGantry(const ChartTerms& terms, const StopSightings& seen, ChartState& state) {
  Positioner& gantry = state.rig.positioner;
  const int num = gantry.num_axes;
  const auto rows = static_cast<Eigen::Index>(seen.views.size());
  Eigen::MatrixXd a(rows, num + 1), t(rows, 3);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const int v = seen.views[static_cast<std::size_t>(i)];
    const double sign = gantry.load == PositionerLoad::kObject ? 1 : -1;
    for (int k = 0; k < num; ++k) a(i, k) = sign * terms.stops[*terms.views[v].stop].axes[k];
    a(i, num) = 1;
    const Rigid3d& pose = state.cam_from_board[v];
    t.row(i) = (pose.rotation.conjugate() * pose.translation).transpose();  // in the board's axes: no rotation left
  }
  const Eigen::MatrixXd centred = a.leftCols(num).rowwise() - a.leftCols(num).colwise().mean();
  const Eigen::JacobiSVD<Eigen::MatrixXd> spread(centred);
  if (rows <= num || spread.singularValues().minCoeff() < kLeastShift_m) {
    return Fail(ErrorCode::kBadInput,
                "the chart was seen at {} stops, which do not move every one of the gantry's {} axes", rows, num);
  }
  const Eigen::MatrixXd solution = a.colPivHouseholderQr().solve(t);
  for (int k = 0; k < num; ++k) gantry.axes_in_stage.col(k) = solution.row(k).transpose().normalized();
  return {};
}

/// How far the poses turn about axes other than their main one, together.
double TurnAboutSecondAxis_rad(const ChartTerms& terms, const Positioner& arm, const std::vector<int>& views) {
  Eigen::MatrixXd turns(static_cast<Eigen::Index>(views.size()), 3);
  const Eigen::Quaterniond first = MountFromWorldAt(terms, arm, views.front()).rotation;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Quaterniond turn = MountFromWorldAt(terms, arm, views[i]).rotation * first.conjugate();
    turns.row(static_cast<Eigen::Index>(i)) = LogRotation(turn).transpose();
  }
  const Eigen::VectorXd sizes = Eigen::JacobiSVD<Eigen::MatrixXd>(turns).singularValues();
  return sizes.size() > 1 ? sizes[1] : 0;
}

/// Hand-eye: cam_from_world = cam_from_mount * (motion at the stop) * anchor_from_world, by OpenCV.
Result<void> StartArm(const ChartTerms& terms, const StopSightings& seen, ChartState& state) {
  Positioner& arm = state.rig.positioner;
  arm.anchor_from_world = {};
  std::vector<cv::Mat> hand_r, hand_t, target_r, target_t;
  const Rigid3d board_from_world = WorldFromBoard(state.place, terms.board.thickness_m).Inverse();
  const auto push = [](const Rigid3d& pose, std::vector<cv::Mat>& rs, std::vector<cv::Mat>& ts) {
    const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
    cv::eigen2cv(r, rs.emplace_back());
    cv::eigen2cv(pose.translation, ts.emplace_back());
  };
  for (const int v : seen.views) {
    push(MountFromWorldAt(terms, arm, v).Inverse(), hand_r, hand_t);
    push(state.cam_from_board[v] * board_from_world, target_r, target_t);
  }
  cv::Mat r, t;
  try {
    // With turns about one axis OpenCV takes their noise for a second.
    if (TurnAboutSecondAxis_rad(terms, arm, seen.views) >= kLeastTurn_rad)
      cv::calibrateHandEye(hand_r, hand_t, target_r, target_t, r, t, cv::CALIB_HAND_EYE_PARK);
  } catch (const cv::Exception&) {
    r.release();
  }
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Constant(NAN);
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  if (!r.empty()) cv::cv2eigen(r, rotation);
  if (!t.empty()) cv::cv2eigen(t, translation);
  if (!rotation.allFinite() || !translation.allFinite()) {
    return Fail(ErrorCode::kBadInput,
                "the chart was seen at {} poses of the arm, which do not determine its hand-eye transform: show it at "
                "three or more poses turned about different axes",
                seen.views.size());
  }
  const Rigid3d mount_from_cam{Eigen::Quaterniond(rotation).normalized(), translation};
  const auto anchor = [&](int v) {
    return MountFromWorldAt(terms, arm, v).Inverse() * mount_from_cam * state.cam_from_board[v] * board_from_world;
  };
  const int best = BestCandidate(terms, state, seen.views, [&](int candidate, int v) {
    return mount_from_cam.Inverse() * MountFromWorldAt(terms, arm, v) * anchor(candidate) * board_from_world.Inverse();
  });
  arm.anchor_from_world = anchor(seen.views[best]);
  return {};
}

}  // namespace

Result<void> StartRig(const ChartTerms& terms, const RigModel& prior, ChartState& state) {
  const auto by_camera = SightingsByCamera(terms, static_cast<int>(state.cameras.size()));
  const auto most = std::max_element(by_camera.begin(), by_camera.end(),
                                     [](const auto& a, const auto& b) { return a.views.size() < b.views.size(); });
  state.rig = prior;
  state.rig.cam_from_mount.assign(state.cameras.size(), std::nullopt);
  state.stop_errors.assign(terms.stops.size(), StopError::Zero());
  state.place = {};
  const PositionerKind kind = prior.positioner.kind;
  const Result<void> start = kind == PositionerKind::kTurntable ? StartTurntable(terms, *most, state)
                             : kind == PositionerKind::kGantry  ? StartGantry(terms, *most, state)
                                                                : StartArm(terms, *most, state);
  if (!start) return Fail(start.error());
  const Rigid3d world_from_board = WorldFromBoard(state.place, terms.board.thickness_m);
  const Positioner& positioner = state.rig.positioner;
  for (const StopSightings& seen : by_camera) {
    if (seen.views.empty()) continue;
    const auto mount = [&](int v) {
      return state.cam_from_board[v] * (MountFromWorldAt(terms, positioner, v) * world_from_board).Inverse();
    };
    const int best = BestCandidate(terms, state, seen.views, [&](int candidate, int v) {
      return mount(candidate) * MountFromWorldAt(terms, positioner, v) * world_from_board;
    });
    state.rig.cam_from_mount[seen.camera] = mount(seen.views[best]);
  }
  return {};
}

}  // namespace rigcal
