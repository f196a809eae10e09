#include "core/adjust/let_go.h"

#include <Eigen/Cholesky>
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

/// A component's value at all stops less their median: a table that was homed anew is off by the same at all of them,
/// which no picture shows.
std::vector<double> OffsetsFromMedian(const std::vector<StopError>& errors, int component) {
  std::vector<double> values;
  for (const StopError& error : errors) values.push_back(error[component]);
  const double median = Median(values);
  for (double& value : values) value -= median;
  return values;
}

/// The component of a stop's error that is largest against what the rig states, less its median over the stops.
struct WorstComponent {
  int component = 0;
  double value = 0, sigmas = 0;
};

std::vector<WorstComponent> WorstOfStops(const RigState& state, const RigTerms& rig) {
  std::vector<WorstComponent> worst(rig.stops.size());
  for (int k = 0; k < kStopErrorSize; ++k) {
    const std::vector<double> offsets = OffsetsFromMedian(state.stop_errors, k);
    for (std::size_t s = 0; s < rig.stops.size(); ++s) {
      const double sigma = rig.stop_error_sigma[s][k];
      if (sigma > 0 && std::abs(offsets[s]) > worst[s].sigmas * sigma) {
        worst[s] = {k, offsets[s], std::abs(offsets[s]) / sigma};
      }
    }
  }
  return worst;
}

/// Rows of RigCovariance that are this camera's, lens and mount.
std::vector<int> FreeRowsOfCamera(const RigPrior& prior, int camera) {
  const int n = static_cast<int>(prior.cameras.size());
  const int lens = RigCovariance::IntrinsicsRow(camera), mount = RigCovariance::MountRow(n, camera);
  std::vector<int> rows = prior.FreeRows();
  std::erase_if(rows, [=](int row) {
    const bool own = (row >= lens && row < lens + kNumIntrinsics) || (row >= mount && row < mount + kMountSize);
    return !own;
  });
  return rows;
}

/// By how much the prior's chi-square falls when all of a camera is let go, the others staying where they are. Lens and
/// mount together: a turn of a few tenths of a degree looks so much like a shift of the principal point that the
/// adjustment may have taken it for one.
std::vector<double> GainsOfRelease(const RigPrior& prior, const Eigen::VectorXd& departure) {
  const std::vector<int> free = prior.FreeRows();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(departure.size(), departure.size());
  information(free, free) = CovarianceFromInformation(prior.covariance.joint(free, free));
  const Eigen::VectorXd pull = information * departure;
  std::vector<double> gains;
  for (int c = 0; c < static_cast<int>(prior.cameras.size()); ++c) {
    const std::vector<int> own = FreeRowsOfCamera(prior, c);
    const Eigen::VectorXd own_pull = pull(own);
    const Eigen::MatrixXd block = information(own, own);
    gains.push_back(own.empty() ? 0 : own_pull.dot(CovarianceFromInformation(block) * own_pull));
  }
  return gains;
}

/// The part that is farthest beyond the limit: how many times its squared limit; 1 and less is within.
struct Candidate {
  int index = -1;
  double excess = 1;
  std::vector<int> others;
};

Candidate WorstMount(const BundleUnknowns& solution, double sigmas, const RigPrior& prior, const LetGo& let_go) {
  const Eigen::VectorXd departure = DepartureFrom(prior, solution.calibration.cameras, solution.rig->model);
  std::vector<double> excess = GainsOfRelease(prior, departure);
  for (std::size_t c = 0; c < excess.size(); ++c) {
    // When all is well the gain is about the number of parameters.
    const auto num_parameters = static_cast<double>(FreeRowsOfCamera(prior, static_cast<int>(c)).size());
    excess[c] /= sigmas * sigmas + 2 * num_parameters;
  }
  for (const LetGo::Mount& mount : let_go.mounts) excess[static_cast<std::size_t>(mount.camera)] = 0;
  Candidate worst;
  for (int c = 0; c < static_cast<int>(excess.size()); ++c) {
    if (excess[c] > worst.excess) worst = {c, excess[c], {}};
  }
  for (int c = 0; worst.index >= 0 && c < static_cast<int>(excess.size()); ++c) {
    if (c != worst.index && excess[c] > kUndecidedShare * worst.excess) worst.others.push_back(c);
  }
  return worst;
}

Candidate WorstStop(const RigState& state, double sigmas, const RigTerms& rig) {
  Candidate worst;
  const std::vector<WorstComponent> components = WorstOfStops(state, rig);
  for (int s = 0; s < static_cast<int>(components.size()); ++s) {
    const double excess = std::pow(components[s].sigmas / sigmas, 2);
    if (excess > worst.excess) worst = {s, excess, {}};
  }
  return worst;
}

std::string SentenceOf(const LetGo::Mount& mount, const Eigen::VectorXd& departure, const RigPrior& prior) {
  const int n = static_cast<int>(prior.cameras.size());
  std::string ids = prior.cameras[mount.camera].id;
  for (const int other : mount.others) ids += " or " + prior.cameras[other].id;
  const int row = RigCovariance::MountRow(n, mount.camera);
  return fmt::format("camera {} moved against the rig since it was calibrated, by {:.3f} deg and {:.3f} mm{}", ids,
                     Degrees(departure.segment<3>(row).norm()), 1e3 * departure.segment<3>(row + 3).norm(),
                     mount.others.empty() ? "" : "; which one cannot be decided");
}

}  // namespace

bool LetGoOfWorst(const BundleUnknowns& solution, double sigmas, RigTerms& rig, LetGo& let_go) {
  const Candidate mount = WorstMount(solution, sigmas, rig.prior, let_go);
  const Candidate stop = WorstStop(*solution.rig, sigmas, rig);
  if (mount.index < 0 && stop.index < 0) return false;
  if (mount.excess > stop.excess) {
    let_go.mounts.push_back({mount.index, mount.others});
    LoosenMount(mount.index, kReleasedRad, kReleasedM, rig.prior);
    return true;
  }
  let_go.stops.push_back(stop.index);
  StopError& sigma = rig.stop_error_sigma[static_cast<std::size_t>(stop.index)];
  for (int k = 0; k < kStopErrorSize; ++k) {
    if (sigma[k] > 0) sigma[k] = k < kNumRotations ? kReleasedRad : kReleasedM;
  }
  return true;
}

std::vector<std::string> SentencesOf(const LetGo& let_go, const BundleUnknowns& solution, const RigTerms& rig) {
  std::vector<std::string> sentences;
  const Eigen::VectorXd departure = DepartureFrom(rig.prior, solution.calibration.cameras, solution.rig->model);
  for (const LetGo::Mount& mount : let_go.mounts) sentences.push_back(SentenceOf(mount, departure, rig.prior));
  const auto names = StopErrorNames(solution.rig->model.positioner);
  const std::vector<WorstComponent> worst = WorstOfStops(*solution.rig, rig);
  for (const int s : let_go.stops) {
    const auto& [component, value, sigmas] = worst[static_cast<std::size_t>(s)];
    const std::string found =
        component < kNumRotations ? fmt::format("{:.3f} deg", Degrees(value)) : fmt::format("{:.3f} mm", 1e3 * value);
    sentences.push_back(
        fmt::format("stop {}: {} of {}, {:.0f} times what the rig states: the positioner slipped or was moved there",
                    rig.stops[static_cast<std::size_t>(s)].id, names[component], found, sigmas));
  }
  return sentences;
}

}  // namespace rigcal
