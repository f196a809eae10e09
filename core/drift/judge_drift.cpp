#include "core/drift/judge_drift.h"

#include <algorithm>

#include "core/base/ensure.h"
#include "core/drift/drift_sentences.h"
#include "core/drift/picture_motion.h"
#include "core/drift/rig_evidence.h"
#include "core/rig/rig_model_pose.h"

namespace rigcal {
namespace {

/// A chi-square of six numbers (a rigid motion) is larger than this by chance once in a thousand times.
constexpr double kSurprising = 22.46;
/// Twice the logarithm of 100: of two that explain the night, the better one is named from such odds on.
constexpr double kNamingEvidence = 9.21;
/// Moved against fewer others than this, nobody can say which one moved.
constexpr std::size_t kMinCamerasToTell = 3;

/// The cameras with a place in the rig and pictures, and last (from three cameras on) all of them together.
struct Case {
  const DriftInput& input;
  RigEvidence evidence;
  std::vector<int> cameras;  ///< per mover but the last
  std::vector<Mover> movers;
  std::vector<PictureRows> rows;  ///< per mover

  [[nodiscard]] bool CanTell() const { return cameras.size() >= kMinCamerasToTell; }
  [[nodiscard]] bool HasTogether() const { return movers.size() > cameras.size(); }
  [[nodiscard]] bool IsTogether(int mover) const { return mover == static_cast<int>(cameras.size()); }
};

Eigen::Index MountRow(const Case& c, int camera) {
  const int row = RigCovariance::MountRow(static_cast<int>(c.input.in_force.cameras.size()), camera);
  const auto found = std::ranges::find(c.evidence.rows, row);
  Ensure(found != c.evidence.rows.end(), "a released mount is free");
  return found - c.evidence.rows.begin();
}

void AddMovers(Case& c) {
  const DriftInput& input = c.input;
  MotionVector width;
  width << Eigen::Vector3d::Constant(input.released_rad), Eigen::Vector3d::Constant(input.released_m);
  const auto num_rows = static_cast<Eigen::Index>(c.evidence.rows.size());
  Mover together{Eigen::MatrixXd::Zero(num_rows, kMotionSize), width};
  for (int camera = 0; camera < static_cast<int>(input.in_force.cameras.size()); ++camera) {
    const auto& mount = input.in_force.model.cam_from_mount[camera];
    if (!mount) continue;
    PictureRows rows = RowsOfCamera(input, camera);
    if (rows.empty()) continue;
    Mover mover{Eigen::MatrixXd::Zero(num_rows, kMotionSize), width};
    mover.by_motion.middleRows<kMotionSize>(MountRow(c, camera)).setIdentity();
    together.by_motion.middleRows<kMotionSize>(MountRow(c, camera)) = DisturbanceThrough(*mount);
    c.cameras.push_back(camera);
    c.movers.push_back(std::move(mover));
    c.rows.push_back(std::move(rows));
  }
  if (c.cameras.size() == 1) c.rows[0] = RowsOfLoneCamera(input, c.cameras[0]);
  if (!c.CanTell()) return;
  c.movers.push_back(std::move(together));
  c.rows.push_back(RowsOfAll(input));
}

/// One mover beside those that moved.
struct Candidate {
  int mover = -1;
  PictureMotion motion;
  double chi_square = 0, log_evidence = 0;
};

Candidate Consider(const Case& c, std::vector<int> moved, int mover) {
  std::erase(moved, mover);
  std::vector<Mover> movers;
  for (const int m : moved) movers.push_back(c.movers[m]);
  const double fit_without = Explain(c.evidence, movers).fit;
  movers.push_back(c.movers[mover]);
  const Explanation with = Explain(c.evidence, movers);
  return {.mover = mover,
          .motion = MotionOf(c.rows[mover], with.motion.back(), with.covariance.back()),
          .chi_square = with.fit - fit_without,
          .log_evidence = with.log_evidence};
}

bool Counts(const Candidate& candidate, const DriftLimits& limits) {
  return candidate.motion.moved_px > limits.drift_px && candidate.chi_square > kSurprising;
}

/// What moved, one at a time, the best explanation first: what moved drags others along until it is let go. The best
/// may be a motion below the limit that another camera would have to be moved beyond it to explain. Where it cannot be
/// told which one moved nothing is taken to have.
std::vector<int> FindMoved(const Case& c) {
  std::vector<int> moved;
  if (!c.CanTell()) return moved;
  bool far = false;  // so far that the rest of what is not linear looks like a motion of all cameras
  while (moved.size() < c.movers.size()) {
    Candidate best;
    bool any_counts = false;
    for (int m = 0; m < static_cast<int>(c.movers.size()); ++m) {
      if (std::ranges::count(moved, m) > 0 || (far && c.IsTogether(m))) continue;
      const Candidate candidate = Consider(c, moved, m);
      any_counts = any_counts || Counts(candidate, c.input.limits);
      const bool better = best.mover < 0 || candidate.log_evidence > best.log_evidence;
      if (candidate.chi_square > kSurprising && better) best = candidate;
    }
    if (!any_counts) break;
    moved.push_back(best.mover);
    far = far || best.motion.moved_px > c.input.limits.failed_px;
  }
  return moved;
}

double EvidenceFor(const Case& c, const std::vector<int>& moved) {
  std::vector<Mover> movers;
  for (const int m : moved) movers.push_back(c.movers[m]);
  return Explain(c.evidence, movers).log_evidence;
}

/// Cameras that in the place of one of those that moved explain the night nearly as well.
std::vector<int> RivalsOf(const Case& c, const std::vector<int>& moved) {
  const double least = EvidenceFor(c, moved) - kNamingEvidence;
  std::vector<int> rivals;
  for (int rival = 0; rival < static_cast<int>(c.cameras.size()); ++rival) {
    if (std::ranges::count(moved, rival) > 0) continue;
    const bool fits = std::ranges::any_of(moved, [&](int replaced) {
      std::vector<int> other = moved;
      std::ranges::replace(other, replaced, rival);
      return !c.IsTogether(replaced) && EvidenceFor(c, other) > least;
    });
    if (fits) rivals.push_back(rival);
  }
  return rivals;
}

CameraDrift DriftOf(const Case& c, const std::vector<int>& moved, int mover) {
  const Candidate candidate = Consider(c, moved, mover);
  CameraDrift drift{.motion = candidate.motion, .chi_square = candidate.chi_square};
  drift.moved = Counts(candidate, c.input.limits) && (!c.CanTell() || std::ranges::count(moved, mover) > 0);
  if (c.IsTogether(mover)) return drift;
  drift.camera = c.input.in_force.cameras[c.cameras[mover]].id;
  drift.evidence = c.input.cameras[c.cameras[mover]];
  return drift;
}

/// Who moved, and whether that can be told: a minority against the rest, and nobody else explains it.
void NameSuspects(const Case& c, const std::vector<int>& moved, DriftFinding& finding) {
  const auto is_camera = [&](int mover) { return !c.IsTogether(mover); };
  const auto num_moved = static_cast<std::size_t>(std::ranges::count_if(moved, is_camera));
  if (std::ranges::none_of(finding.cameras, &CameraDrift::moved)) return;
  const bool minority = c.CanTell() && 2 * num_moved < c.cameras.size();
  const std::vector<int> rivals = minority ? RivalsOf(c, moved) : std::vector<int>{};
  finding.which_is_told = minority && rivals.empty();
  for (int m = 0; m < static_cast<int>(c.cameras.size()); ++m) {
    const bool suspect = !minority || std::ranges::count(moved, m) + std::ranges::count(rivals, m) > 0;
    if (suspect) finding.suspects.push_back(finding.cameras[m].camera);
  }
}

class Reasons {
 public:
  Reasons(const DriftInput& input, DriftFinding& finding) : limits_(input.limits), input_(input), finding_(finding) {}

  void Failed() {
    for (const CameraDrift& drift : finding_.cameras) {
      const bool enough = drift.evidence.num_features >= limits_.min_features;
      if (drift.moved && drift.motion.moved_px > limits_.failed_px)
        Add(DriftState::kFailed, {"motion", drift.motion.moved_px, limits_.failed_px, "px", drift.camera});
      if (enough && drift.evidence.after_px.value_or(0) > limits_.holdout_px)
        Add(DriftState::kFailed, {"holdout", *drift.evidence.after_px, limits_.holdout_px, "px", drift.camera});
    }
    if (!input_.slips.empty())
      Add(DriftState::kFailed, {"slipped stops", static_cast<double>(input_.slips.size()), 0, "", std::nullopt});
  }

  void Drifting() {
    for (const CameraDrift& drift : finding_.cameras) {
      if (drift.moved)
        Add(DriftState::kDrifting, {"motion", drift.motion.moved_px, limits_.drift_px, "px", drift.camera});
    }
    if (finding_.together && finding_.together->moved)
      Add(DriftState::kDrifting,
          {"motion of all cameras", finding_.together->motion.moved_px, limits_.drift_px, "px", std::nullopt});
  }

  void Inconclusive() {
    for (std::size_t c = 0; c < input_.in_force.cameras.size(); ++c) {
      const int num_features = input_.cameras[c].num_features;
      if (num_features < limits_.min_features)
        Add(DriftState::kInconclusive, {"features", static_cast<double>(num_features),
                                        static_cast<double>(limits_.min_features), "", input_.in_force.cameras[c].id});
    }
    for (const CameraDrift& drift : finding_.cameras) JudgeSharpness(drift);
  }

 private:
  void JudgeSharpness(const CameraDrift& drift) {
    const PictureMotion& motion = drift.motion;
    const double limit_px = limits_.drift_px / limits_.sigmas;
    if (motion.sigma_px > limit_px)
      Add(DriftState::kInconclusive, {"sigma", motion.sigma_px, limit_px, "px", drift.camera});
    if (motion.moved_px > limits_.drift_px && !drift.moved)
      Add(DriftState::kInconclusive,
          {"motion no larger than chance", motion.moved_px, limits_.drift_px, "px", drift.camera});
    const CameraEvidence& evidence = drift.evidence;
    if (!evidence.before_px || !evidence.after_px) return;
    const double most_px = *evidence.before_px * limits_.holdout_growth + limits_.holdout_growth_px;
    if (*evidence.after_px > most_px)
      Add(DriftState::kInconclusive, {"holdout growth", *evidence.after_px, most_px, "px", drift.camera});
  }

  /// The first kind of reason decides.
  void Add(DriftState state, DriftReason reason) {
    if (finding_.reasons.empty()) finding_.state = state;
    finding_.reasons.push_back(std::move(reason));
  }

  const DriftLimits& limits_;
  const DriftInput& input_;
  DriftFinding& finding_;
};

/// Nothing could be adjusted.
DriftFinding Unmeasured(const DriftInput& input) {
  DriftFinding finding{.state = DriftState::kInconclusive, .limit_px = input.limits.drift_px};
  Reasons(input, finding).Inconclusive();
  if (finding.reasons.empty()) finding.reasons.push_back({"refinement", 0, 1, "rounds", std::nullopt});
  finding.sentences = SentencesOf(input, finding);
  return finding;
}

void EnsurePromises(const DriftInput& input) {
  const std::size_t num_cameras = input.in_force.cameras.size();
  Ensure(input.cameras.size() == num_cameras && input.found.cameras.size() == num_cameras &&
             input.placed.cameras.size() == num_cameras,
         "the same cameras everywhere");
  Ensure(input.stop_of_view.size() == input.placed.views.size(), "a stop for every view");
  Ensure(input.released_rad > 0 && input.released_m > 0, "the mounts were released");
}

}  // namespace

DriftFinding JudgeDrift(const DriftInput& input) {
  EnsurePromises(input);
  if (!input.found.rig) return Unmeasured(input);
  Case c{.input = input, .evidence = EvidenceOf(input)};
  AddMovers(c);
  const std::vector<int> moved = FindMoved(c);

  DriftFinding finding{.state = DriftState::kOk, .limit_px = input.limits.drift_px};
  for (int m = 0; m < static_cast<int>(c.cameras.size()); ++m) finding.cameras.push_back(DriftOf(c, moved, m));
  if (c.HasTogether()) finding.together = DriftOf(c, moved, static_cast<int>(c.cameras.size()));
  NameSuspects(c, moved, finding);

  Reasons reasons(input, finding);
  reasons.Failed();
  reasons.Drifting();
  if (finding.reasons.empty()) reasons.Inconclusive();
  finding.sentences = SentencesOf(input, finding);
  return finding;
}

}  // namespace rigcal
