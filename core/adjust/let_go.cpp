#include "core/adjust/let_go.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/median.h"
#include "core/rig/camera_information.h"
#include "core/rig/rig_prior.h"

namespace rigcal {
namespace {

/// Width of a prior that was let go: more than a camera or a table moves while its pictures still match.
constexpr double kReleasedRad = 0.1, kReleasedM = 0.1;
/// Two cameras whose release explains the pictures this equally well cannot be told apart.
constexpr double kUndecidedShare = 0.8;
constexpr int kMountSize = 6, kNumRotations = 3;

double Degrees(double angle_rad) {
  return angle_rad * 180 / std::numbers::pi;
}

/// What is beyond must be as unlikely as `sigmas` of one number: when all is well a chi-square is about its number of
/// parameters.
double Limit(double sigmas, std::size_t num_parameters) {
  return sigmas * sigmas + 2 * static_cast<double>(num_parameters);
}

std::vector<bool> StopsSeen(const BundleUnknowns& solution, const RigTerms& rig) {
  std::vector<bool> seen(rig.stops.size(), false);
  for (const Measurement& m : solution.measurements.items) seen[rig.stop_of_view[m.view]] = true;
  return seen;
}

/// The component of a stop's error that is largest against what the rig states. Less its median over the stops: a table
/// that was homed anew is off by the same at all of them, which no picture shows.
struct WorstComponent {
  int component = 0;
  double value = 0, sigmas = 0;
};

/// Per stop; nothing where it was not seen, or where fewer than three were.
std::vector<WorstComponent> WorstOfStops(const BundleUnknowns& solution, const RigTerms& rig) {
  constexpr int kLeastStops = 3;
  const std::vector<bool> seen = StopsSeen(solution, rig);
  std::vector<WorstComponent> worst(rig.stops.size());
  if (std::ranges::count(seen, true) < kLeastStops) return worst;
  for (int k = 0; k < kStopErrorSize; ++k) {
    std::vector<double> values;
    for (std::size_t s = 0; s < seen.size(); ++s) {
      if (seen[s]) values.push_back(solution.rig->stop_errors[s][k]);
    }
    const double median = Median(values);
    for (std::size_t s = 0; s < seen.size(); ++s) {
      const double sigma = rig.stop_error_sigma[s][k], offset = solution.rig->stop_errors[s][k] - median;
      if (seen[s] && sigma > 0 && std::abs(offset) > worst[s].sigmas * sigma) {
        worst[s] = {k, offset, std::abs(offset) / sigma};
      }
    }
  }
  return worst;
}

/// Rows of RigCovariance that are this camera's, lens and mount.
std::vector<int> FreeRowsOfCamera(const RigPrior& prior, int camera) {
  const int lens = RigCovariance::IntrinsicsRow(camera);
  const int mount = RigCovariance::MountRow(static_cast<int>(prior.cameras.size()), camera);
  std::vector<int> rows = prior.FreeRows();
  std::erase_if(rows, [=](int row) {
    const bool own = (row >= lens && row < lens + kNumIntrinsics) || (row >= mount && row < mount + kMountSize);
    return !own;
  });
  return rows;
}

/// By how much the prior's chi-square falls when all of a camera is let go, the others staying where they are, over its
/// limit. Lens and mount together: a turn of a few tenths of a degree looks so much like a shift of the principal point
/// that the adjustment may have taken it for one.
std::vector<double> ExcessOfCameras(const BundleUnknowns& solution, double sigmas, const RigPrior& prior) {
  const Eigen::VectorXd departure = DepartureFrom(prior, solution.calibration.cameras, solution.rig->model);
  const std::vector<int> free = prior.FreeRows();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(departure.size(), departure.size());
  information(free, free) = CovarianceFromInformation(prior.covariance.joint(free, free));
  const Eigen::VectorXd pull = information * departure;
  std::vector<double> excess;
  for (int c = 0; c < static_cast<int>(prior.cameras.size()); ++c) {
    const std::vector<int> own = FreeRowsOfCamera(prior, c);
    const Eigen::VectorXd own_pull = pull(own);
    const Eigen::MatrixXd block = information(own, own);
    const double gain = own.empty() ? 0 : own_pull.dot(CovarianceFromInformation(block) * own_pull);
    excess.push_back(gain / Limit(sigmas, own.size()));
  }
  return excess;
}

/// The part that is farthest beyond its limit, and how many times the limit's square that is.
struct Candidate {
  int index = -1;
  double excess = 1;
};

void Consider(int index, double excess, Candidate& worst) {
  if (excess > worst.excess) worst = {index, excess};
}

Candidate WorstMount(const BundleUnknowns& solution, double sigmas, const RigPrior& prior, const LetGo& let_go,
                     std::vector<int>& others) {
  std::vector<double> excess = ExcessOfCameras(solution, sigmas, prior);
  for (const LetGo::Mount& mount : let_go.mounts) excess[static_cast<std::size_t>(mount.camera)] = 0;
  Candidate worst;
  for (int c = 0; c < static_cast<int>(excess.size()); ++c) Consider(c, excess[c], worst);
  for (int c = 0; worst.index >= 0 && c < static_cast<int>(excess.size()); ++c) {
    if (c != worst.index && excess[c] > kUndecidedShare * worst.excess) others.push_back(c);
  }
  return worst;
}

Candidate WorstStop(const BundleUnknowns& solution, double sigmas, const RigTerms& rig, const LetGo& let_go) {
  Candidate worst;
  const std::vector<WorstComponent> components = WorstOfStops(solution, rig);
  for (int s = 0; s < static_cast<int>(components.size()); ++s) {
    if (std::ranges::count(let_go.stops, s) == 0) Consider(s, std::pow(components[s].sigmas / sigmas, 2), worst);
  }
  return worst;
}

/// How far a camera's mount, or its lens, is from the prior in the end, in squared sigmas over the limit.
double FinalExcess(const Eigen::VectorXd& departure, double sigmas, const RigPrior& prior, int first, int count) {
  std::vector<int> rows = prior.FreeRows();
  std::erase_if(rows, [=](int row) { return row < first || row >= first + count; });
  const Eigen::VectorXd own = departure(rows);
  return own.dot(CovarianceFromInformation(prior.covariance.joint(rows, rows)) * own) / Limit(sigmas, rows.size());
}

std::string MountSentence(const LetGo::Mount& mount, const Eigen::VectorXd& departure, const RigPrior& prior) {
  std::string ids = prior.cameras[mount.camera].id;
  for (const int other : mount.others) ids += " or " + prior.cameras[other].id;
  const int row = RigCovariance::MountRow(static_cast<int>(prior.cameras.size()), mount.camera);
  const Eigen::Vector3d turn_rad = departure.segment<3>(row), shift_m = departure.segment<3>(row + 3);
  constexpr double kMostlyAlong = 0.8;  // of the shift is along the line of sight
  const double distance_m = prior.model.cam_from_mount[mount.camera]->translation.norm();
  const bool like_focus =
      std::abs(shift_m.z()) > kMostlyAlong * shift_m.norm() && shift_m.norm() > turn_rad.norm() * distance_m;
  return fmt::format("camera {} moved against the rig since it was calibrated, by {:.3f} deg and {:.3f} mm{}{}", ids,
                     Degrees(turn_rad.norm()), 1e3 * shift_m.norm(),
                     like_focus ? " (a change of focus would look much the same)" : "",
                     mount.others.empty() ? "" : "; which one cannot be decided");
}

std::string LensSentence(int camera, const BundleUnknowns& solution, const RigPrior& prior) {
  const Camera &now = solution.calibration.cameras[camera], &before = prior.cameras[camera];
  return fmt::format(
      "camera {}: its lens changed since it was calibrated, the focal length by {:.3f} %, the principal point by "
      "{:.2f} "
      "px",
      before.id, 100 * (now.fx_px / before.fx_px - 1), std::hypot(now.cx_px - before.cx_px, now.cy_px - before.cy_px));
}

std::string StopSentence(const WorstComponent& worst, int stop, const RigState& state, const RigTerms& rig) {
  const std::string found = worst.component < kNumRotations ? fmt::format("{:.3f} deg", Degrees(worst.value))
                                                            : fmt::format("{:.3f} mm", 1e3 * worst.value);
  return fmt::format("stop {}: {} of {}, {:.0f} times what the rig states: the positioner slipped or was moved there",
                     rig.stops[stop].id, StopErrorNames(state.model.positioner)[worst.component], found, worst.sigmas);
}

}  // namespace

bool LetGoOfWorst(const BundleUnknowns& solution, double sigmas, RigTerms& rig, LetGo& let_go) {
  std::vector<int> others;
  const Candidate mount = WorstMount(solution, sigmas, rig.prior, let_go, others);
  const Candidate stop = WorstStop(solution, sigmas, rig, let_go);
  const double worst = std::max(mount.excess, stop.excess);
  if (!(worst > 1)) return false;
  if (mount.excess == worst) {
    let_go.mounts.push_back({mount.index, others});
    LoosenMount(mount.index, kReleasedRad, kReleasedM, rig.prior);
  } else {
    let_go.stops.push_back(stop.index);
    StopError& sigma = rig.stop_error_sigma[static_cast<std::size_t>(stop.index)];
    for (int k = 0; k < kStopErrorSize; ++k) {
      if (sigma[k] > 0) sigma[k] = std::max(sigma[k], k < kNumRotations ? kReleasedRad : kReleasedM);
    }
  }
  return true;
}

std::vector<std::string> SentencesOf(const LetGo& let_go, double sigmas, const BundleUnknowns& solution,
                                     const RigTerms& rig) {
  std::vector<std::string> sentences;
  const int n = static_cast<int>(rig.prior.cameras.size());
  const Eigen::VectorXd departure = DepartureFrom(rig.prior, solution.calibration.cameras, solution.rig->model);
  for (const LetGo::Mount& mount : let_go.mounts) {
    const int first = RigCovariance::MountRow(n, mount.camera);
    if (FinalExcess(departure, sigmas, rig.prior, first, kMountSize) > 1) {
      sentences.push_back(MountSentence(mount, departure, rig.prior));
    }
  }
  for (int camera = 0; camera < n; ++camera) {
    const int first = RigCovariance::IntrinsicsRow(camera);
    if (FinalExcess(departure, sigmas, rig.prior, first, kNumIntrinsics) > 1) {
      sentences.push_back(LensSentence(camera, solution, rig.prior));
    }
  }
  for (std::string& sentence : SlipSentences(let_go, sigmas, solution, rig)) sentences.push_back(std::move(sentence));
  if (ScaleIsLost(let_go, solution)) {
    sentences.emplace_back(
        "no camera kept its place in the rig: how large the object is, and where the axis is, cannot be told; show the "
        "chart again");
  }
  return sentences;
}

std::vector<std::string> SlipSentences(const LetGo& let_go, double sigmas, const BundleUnknowns& solution,
                                       const RigTerms& rig) {
  const std::vector<WorstComponent> worst = WorstOfStops(solution, rig);
  std::vector<std::string> sentences;
  for (const int s : let_go.stops) {
    if (worst[s].sigmas > sigmas) sentences.push_back(StopSentence(worst[s], s, *solution.rig, rig));
  }
  return sentences;
}

bool ScaleIsLost(const LetGo& let_go, const BundleUnknowns& solution) {
  if (solution.rig->model.positioner.kind != PositionerKind::kTurntable) return false;
  return std::ranges::all_of(solution.measurements.items, [&](const Measurement& m) {
    const int camera = solution.calibration.views[m.view].camera;
    return std::ranges::count(let_go.mounts, camera, &LetGo::Mount::camera) > 0;
  });
}

}  // namespace rigcal
