#include "core/drift/judge_drift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "core/drift/rig_evidence.h"
#include "tests/drift/night.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kNumStops = 4, kNumPoints = 200;
constexpr double kFocalPx = 1520;
/// A turn about x or y of the camera that moves the object's picture by about 0.3 px (issue 5).
constexpr double kTurnRad = 0.3 / kFocalPx;

/// A studio with a calibration in force and the recording of a night there; made once, it takes a while.
struct Studio {
  explicit Studio(int num_cameras)
      : in_force(synthetic::InForce(num_cameras)), night(synthetic::Record(in_force, kNumStops, kNumPoints, 5)) {}
  RigPrior in_force;
  synthetic::RecordedNight night;

  [[nodiscard]] DriftInput Input(const synthetic::Happened& happened, std::uint64_t seed, double noise = 1) const {
    return synthetic::InputFor(in_force, night, happened, seed, noise);
  }
  [[nodiscard]] DriftInput Undisturbed(std::uint64_t seed = 1) const {
    return Input(synthetic::Nothing(in_force), seed);
  }
  [[nodiscard]] DriftInput Turned(int camera, const Eigen::Vector3d& turn_rad, std::uint64_t seed = 1) const {
    return Input(synthetic::Turned(in_force, camera, turn_rad), seed);
  }
};

const Studio& StudioOf(int num_cameras) {
  static std::map<int, Studio> studios;
  return studios.try_emplace(num_cameras, num_cameras).first->second;
}

std::vector<std::string> ChecksOf(const DriftFinding& finding) {
  std::vector<std::string> checks;
  for (const DriftReason& reason : finding.reasons) checks.push_back(reason.check);
  return checks;
}

TEST(EvidenceOf, TakesThePriorOut) {
  const Studio& studio = StudioOf(3);
  const RigEvidence evidence = EvidenceOf(studio.Undisturbed());
  // What the features say of the rig once the stops' errors, known to their sigmas, are eliminated.
  const auto known = synthetic::PriorOf(studio.in_force, studio.night);
  const auto num_rig = static_cast<Eigen::Index>(evidence.rows.size());
  Eigen::MatrixXd all = studio.night.information(known.columns, known.columns);
  const Eigen::Index num_stops = all.rows() - num_rig;
  all.bottomRightCorner(num_stops, num_stops) +=
      Eigen::MatrixXd(known.covariance.bottomRightCorner(num_stops, num_stops).inverse());
  const Eigen::MatrixXd cross = all.topRightCorner(num_rig, num_stops);
  const Eigen::MatrixXd expected =
      all.topLeftCorner(num_rig, num_rig) -
      cross * all.bottomRightCorner(num_stops, num_stops).ldlt().solve(Eigen::MatrixXd(cross.transpose()));
  const Eigen::VectorXd scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd off = scale.asDiagonal() * (evidence.information - expected) * scale.asDiagonal();
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-6);
  // A night without errors in which a camera turned and the focal length, which its prior holds back, grew by 5 px.
  synthetic::Happened happened = synthetic::Turned(studio.in_force, 1, {kTurnRad, 0, 0});
  happened[RigCovariance::IntrinsicsRow(1) + kFx] = 5;
  const Eigen::VectorXd pull = expected * happened(evidence.rows);
  const Eigen::VectorXd found = EvidenceOf(studio.Input(happened, 1, 0)).pull;
  EXPECT_LT((found - pull).cwiseProduct(scale).norm(), 1e-4 * pull.cwiseProduct(scale).norm());
}

TEST(JudgeDrift, UndisturbedNightsAreOkAndTheStatedSigmaIsHonest) {
  const Studio& studio = StudioOf(3);
  constexpr int kNights = 100;
  double chi_square = 0, shift2 = 0;
  for (int night = 0; night < kNights; ++night) {
    const DriftFinding finding = JudgeDrift(studio.Undisturbed(static_cast<std::uint64_t>(night)));
    EXPECT_EQ(finding.state, DriftState::kOk) << finding.sentences[0];
    EXPECT_THAT(finding.reasons, IsEmpty());
    EXPECT_THAT(finding.suspects, IsEmpty());
    ASSERT_EQ(finding.cameras.size(), 3U);
    for (const CameraDrift& drift : finding.cameras) {
      chi_square += drift.chi_square / (3 * kNights);
      shift2 += drift.motion.shift_px.cwiseQuotient(drift.motion.shift_sigma_px).squaredNorm() / (2 * 3 * kNights);
    }
  }
  EXPECT_NEAR(chi_square, 6, 1);  // of six numbers, 300 times: +- 0.2, less what no picture shows
  EXPECT_NEAR(shift2, 1, 0.2);
}

TEST(JudgeDrift, TheCameraThatTurnedIsNamedWithItsWay) {
  const Studio& studio = StudioOf(3);
  // About +y of the camera (down): what it sees moves to the right; about +x (right): up, as y points down.
  const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>> turns = {{{0, kTurnRad, 0}, {1, 0}},
                                                                          {{0, -kTurnRad, 0}, {-1, 0}},
                                                                          {{kTurnRad, 0, 0}, {0, -1}},
                                                                          {{-kTurnRad, 0, 0}, {0, 1}}};
  for (int camera = 0; camera < 3; ++camera) {
    for (const auto& [turn_rad, way] : turns) {
      const DriftFinding finding = JudgeDrift(studio.Turned(camera, turn_rad, 40 + static_cast<std::uint64_t>(camera)));
      EXPECT_EQ(finding.state, DriftState::kDrifting) << finding.sentences[0];
      const CameraDrift& drift = finding.cameras[static_cast<std::size_t>(camera)];
      EXPECT_THAT(finding.suspects, ElementsAre(drift.camera));
      EXPECT_TRUE(finding.which_is_told);
      EXPECT_THAT(ChecksOf(finding), ElementsAre("motion"));
      EXPECT_EQ(finding.reasons[0].camera, drift.camera);
      EXPECT_NEAR(drift.motion.moved_px, 0.3, 4 * drift.motion.sigma_px);
      EXPECT_GT(drift.motion.shift_px.normalized().dot(way), 0.9);
      EXPECT_THAT(finding.sentences[0], HasSubstr("drifting: camera " + drift.camera + " moved by"));
      EXPECT_THAT(finding.sentences[0], HasSubstr(way.x() > 0.5    ? "right"
                                                  : way.x() < -0.5 ? "left"
                                                  : way.y() > 0.5  ? "down"
                                                                   : "up"));
    }
  }
}

TEST(JudgeDrift, ATurnIsFoundAndNamedInNearlyEveryNight) {
  const Studio& studio = StudioOf(3);
  int found = 0;
  constexpr int kNights = 60;
  for (int night = 0; night < kNights; ++night) {
    Random random(static_cast<std::uint64_t>(1000 + night));
    const double angle = random.Uniform(0, 2 * std::numbers::pi);
    const int camera = night % 3;
    const DriftFinding finding =
        JudgeDrift(studio.Turned(camera, kTurnRad * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0),
                                 static_cast<std::uint64_t>(2000 + night)));
    found += finding.which_is_told && finding.suspects == std::vector<std::string>{"cam" + std::to_string(camera)};
  }
  EXPECT_GE(found, kNights - 1);
}

TEST(JudgeDrift, WithTwoCamerasItCannotBeToldWhich) {
  for (int camera = 0; camera < 2; ++camera) {
    DriftInput input = StudioOf(2).Turned(camera, {1.5 * kTurnRad, 0, 0});
    input.limits.drift_px = 0.2;  // two cameras know less of each other than three
    const DriftFinding finding = JudgeDrift(input);
    EXPECT_EQ(finding.state, DriftState::kDrifting) << finding.sentences[0];
    EXPECT_FALSE(finding.which_is_told);
    EXPECT_THAT(finding.suspects, ElementsAre("cam0", "cam1"));
    EXPECT_FALSE(finding.together);
    EXPECT_THAT(finding.sentences[0], HasSubstr("camera cam0, camera cam1, the turntable moved against each other"));
    EXPECT_THAT(finding.sentences[0], HasSubstr("which one cannot be told"));
  }
  DriftInput quiet = StudioOf(2).Undisturbed();
  quiet.limits.drift_px = 0.2;
  EXPECT_EQ(JudgeDrift(quiet).state, DriftState::kOk) << JudgeDrift(quiet).sentences[0];
}

TEST(JudgeDrift, OneCameraAndThePositionerCannotBeToldApart) {
  const Studio& studio = StudioOf(1);
  DriftInput input = studio.Turned(0, {0, 20 * kTurnRad, 0});  // across the axis, which wobbles by 0.3 px itself
  input.limits.drift_px = 1;
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kDrifting) << finding.sentences[0];
  EXPECT_FALSE(finding.which_is_told);
  EXPECT_THAT(finding.suspects, ElementsAre("cam0"));
  EXPECT_FALSE(finding.together);
  EXPECT_THAT(finding.sentences[0], HasSubstr("the turntable"));
  EXPECT_THAT(finding.sentences[0], HasSubstr("cannot be told"));
  // Along the axis it looks like an object that stands elsewhere: nobody can see it, and it is no large sigma either.
  DriftInput along =
      studio.Input(synthetic::AllMoved(studio.in_force, (MotionVector() << 0, 0, 0, 0, 0, 1e-3).finished()), 1);
  along.limits.drift_px = 1;
  EXPECT_EQ(JudgeDrift(along).state, DriftState::kOk) << JudgeDrift(along).sentences[0];
}

TEST(JudgeDrift, CamerasThatMovedTogetherAreNoDriftOfOne) {
  const Studio& studio = StudioOf(3);
  // 3 mm along the axis, and 0.5 degrees about it: the object might as well stand elsewhere.
  for (const int k : {2, 5}) {
    MotionVector motion = MotionVector::Zero();
    motion[k] = k == 2 ? 0.01 : 3e-3;
    const DriftFinding finding = JudgeDrift(studio.Input(synthetic::AllMoved(studio.in_force, motion), 3));
    EXPECT_EQ(finding.state, DriftState::kOk) << finding.sentences[0];
    ASSERT_TRUE(finding.together);
    EXPECT_LT(finding.together->motion.moved_px, 0.2);
    EXPECT_LT(finding.together->motion.sigma_px, 0.1);
  }
  // 1 mm across it: that the pictures show, and that it is no single camera.
  MotionVector across = MotionVector::Zero();
  across[3] = 1e-3;
  const DriftFinding finding = JudgeDrift(studio.Input(synthetic::AllMoved(studio.in_force, across), 3));
  EXPECT_EQ(finding.state, DriftState::kDrifting) << finding.sentences[0];
  EXPECT_THAT(finding.suspects, IsEmpty());
  EXPECT_FALSE(finding.which_is_told);
  ASSERT_TRUE(finding.together);
  EXPECT_TRUE(finding.together->moved);
  EXPECT_THAT(ChecksOf(finding), ElementsAre("motion of all cameras"));
  EXPECT_THAT(finding.sentences[0], HasSubstr("all cameras moved together against the turntable"));
}

TEST(JudgeDrift, BesideACameraThatFailedNoMotionOfAllIsLookedFor) {
  const Studio& studio = StudioOf(3);
  MotionVector across = MotionVector::Zero();
  across[3] = 1e-3;
  const synthetic::Happened both =
      synthetic::AllMoved(studio.in_force, across) + synthetic::Turned(studio.in_force, 1, {0, 100 * kTurnRad, 0});
  DriftInput input = studio.Input(both, 3);
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kFailed) << finding.sentences[0];
  EXPECT_FALSE(finding.together->moved);
  input.limits.failed_px = 100;
  EXPECT_TRUE(JudgeDrift(input).together->moved) << JudgeDrift(input).sentences[0];
}

TEST(JudgeDrift, AMinorityIsNamedAndAMajorityIsNot) {
  const Studio& five = StudioOf(5);
  synthetic::Happened two = synthetic::Turned(five.in_force, 1, {3 * kTurnRad, 0, 0});
  two += synthetic::Turned(five.in_force, 3, {0, 2 * kTurnRad, 0});
  const DriftFinding named = JudgeDrift(five.Input(two, 8));
  EXPECT_TRUE(named.which_is_told) << named.sentences[0];
  EXPECT_THAT(named.suspects, ElementsAre("cam1", "cam3"));

  const Studio& three = StudioOf(3);
  two = synthetic::Turned(three.in_force, 0, {3 * kTurnRad, 0, 0});
  two += synthetic::Turned(three.in_force, 2, {-2 * kTurnRad, 2 * kTurnRad, 0});
  const DriftFinding open = JudgeDrift(three.Input(two, 8));
  EXPECT_EQ(open.state, DriftState::kDrifting);
  EXPECT_FALSE(open.which_is_told) << open.sentences[0];
  EXPECT_THAT(open.suspects, ElementsAre("cam0", "cam1", "cam2"));
}

TEST(JudgeDrift, HalfOfTheCamerasAreNotNamed) {
  const Studio& four = StudioOf(4);
  synthetic::Happened two = synthetic::Turned(four.in_force, 1, {3 * kTurnRad, 0, 0});
  two += synthetic::Turned(four.in_force, 3, {0, 3 * kTurnRad, 0});
  const DriftFinding finding = JudgeDrift(four.Input(two, 8));
  EXPECT_EQ(finding.state, DriftState::kDrifting);
  EXPECT_FALSE(finding.which_is_told) << finding.sentences[0];
  EXPECT_THAT(finding.suspects, ElementsAre("cam0", "cam1", "cam2", "cam3"));
}

TEST(JudgeDrift, WhereTheThirdIsNoReferenceTheOtherTwoCannotBeToldApart) {
  Studio studio = StudioOf(3);
  LoosenMount(2, 2e-3, 2e-3, studio.in_force);  // nobody knows well where it stands
  DriftInput input = studio.Input(synthetic::Turned(studio.in_force, 0, {3 * kTurnRad, 0, 0}), 1, 0);
  input.limits.drift_px = 0.2;
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kDrifting) << finding.sentences[0];
  EXPECT_FALSE(finding.which_is_told) << finding.sentences[0];
  EXPECT_THAT(finding.suspects, ElementsAre("cam0", "cam1"));
}

TEST(JudgeDrift, TheLimitItselfIsStillOk) {
  DriftInput input = StudioOf(3).Turned(1, {kTurnRad, 0, 0}, 5);
  const double moved_px = JudgeDrift(input).cameras[1].motion.moved_px;
  input.limits.sigmas = 1;
  input.limits.drift_px = moved_px;
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kOk);
  input.limits.drift_px = std::nextafter(moved_px, 0.0);
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kDrifting);
  input.limits.failed_px = moved_px;
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kDrifting);
  input.limits.failed_px = std::nextafter(moved_px, 0.0);
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kFailed);
}

TEST(JudgeDrift, ASigmaThatIsTooLargeIsInconclusive) {
  DriftInput input = StudioOf(3).Undisturbed();
  double largest_px = 0;
  for (const CameraDrift& drift : JudgeDrift(input).cameras) largest_px = std::max(largest_px, drift.motion.sigma_px);
  input.limits.sigmas = 3;
  input.limits.drift_px = 1.0001 * 3 * largest_px;
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kOk);
  input.limits.drift_px = 0.9999 * 3 * largest_px;
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kInconclusive);
  EXPECT_THAT(ChecksOf(finding), ElementsAre("sigma"));
  EXPECT_THAT(finding.sentences[0], HasSubstr("inconclusive: sigma (cam"));
}

TEST(JudgeDrift, AMotionThatMayBeChanceIsInconclusive) {
  DriftInput input = StudioOf(3).Undisturbed();
  input.limits.sigmas = 1e-3;
  input.limits.drift_px = 1e-4;  // anything is more
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kInconclusive);
  EXPECT_THAT(ChecksOf(finding), ElementsAre("motion no larger than chance", "motion no larger than chance",
                                             "motion no larger than chance"));
}

TEST(JudgeDrift, ACameraThatShowsTooLittleIsInconclusive) {
  DriftInput input = StudioOf(3).Undisturbed();
  input.cameras[2].num_features = input.limits.min_features;
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kOk);
  input.cameras[2].num_features = input.limits.min_features - 1;
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kInconclusive);
  EXPECT_THAT(ChecksOf(finding), ElementsAre("features"));
  EXPECT_EQ(finding.reasons[0].camera, "cam2");
  // What the others show is found all the same.
  DriftInput turned = StudioOf(3).Turned(0, {0, kTurnRad, 0});
  turned.cameras[2].num_features = 0;
  EXPECT_EQ(JudgeDrift(turned).state, DriftState::kDrifting);
}

TEST(JudgeDrift, HoldoutErrorsThatNothingExplainsFail) {
  DriftInput input = StudioOf(3).Undisturbed();
  input.cameras[1].before_px = 3;
  input.cameras[1].after_px = input.limits.holdout_px;
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kOk);
  input.cameras[1].after_px = 1.001 * input.limits.holdout_px;
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kFailed);
  EXPECT_THAT(ChecksOf(finding), ElementsAre("holdout"));
  EXPECT_THAT(finding.sentences[0], HasSubstr("failed: holdout (cam1)"));
  input.cameras[1].num_features = 3;  // three features prove nothing
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kInconclusive);
}

TEST(JudgeDrift, ARefinementThatMakesItWorseIsInconclusive) {
  DriftInput input = StudioOf(3).Undisturbed();
  input.cameras[0].before_px = 0.2;
  input.cameras[0].after_px = 0.26;
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kOk);
  input.cameras[0].after_px = 0.28;
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kInconclusive);
  EXPECT_THAT(ChecksOf(JudgeDrift(input)), ElementsAre("holdout growth"));
  input.cameras[0].before_px.reset();
  EXPECT_EQ(JudgeDrift(input).state, DriftState::kOk);
}

TEST(JudgeDrift, ASlipIsNamedAsWhatItIs) {
  DriftInput input = StudioOf(3).Undisturbed();
  input.slips = {"stop 02: step error of 1.000 deg, 35 times what the rig states"};
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kFailed);
  EXPECT_THAT(finding.suspects, IsEmpty());
  EXPECT_THAT(ChecksOf(finding), ElementsAre("slipped stops"));
  EXPECT_THAT(finding.sentences[0], HasSubstr("failed: stop 02: step error of 1.000 deg"));
}

TEST(JudgeDrift, WithoutARefinementNothingIsTold) {
  DriftInput input = StudioOf(3).Undisturbed();
  input.found.rig.reset();
  input.points.clear();
  input.cameras.assign(3, {});
  input.notes = {"no picture shows anything"};
  const DriftFinding finding = JudgeDrift(input);
  EXPECT_EQ(finding.state, DriftState::kInconclusive);
  EXPECT_EQ(finding.reasons.size(), 3U);
  EXPECT_THAT(finding.cameras, IsEmpty());
  EXPECT_THAT(finding.sentences, ElementsAre(HasSubstr("inconclusive: features (cam0)"), "no picture shows anything"));
}

}  // namespace
}  // namespace rigcal
