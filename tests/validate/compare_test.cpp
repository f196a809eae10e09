#include "core/validate/compare.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/validate/cameras_for_test.h"

namespace rigcal {
namespace {

using test::DisturbedBySines;
using test::InFrame;
using test::LatticePoints;
using test::SixCameras;

constexpr double kAgreementPx = 0.001;  ///< what is asked of the agreement with ../shared/tools/gt_error.py

/// What gt_error.py prints (mean, median, rms, p95, max) for the same cameras, written to par files.
struct Expected {
  double mean_px, median_px, rms_px, p95_px, max_px;
};

void ExpectDistances(const CompareReport& report, const Expected& expected) {
  EXPECT_NEAR(report.mean_px, expected.mean_px, kAgreementPx);
  EXPECT_NEAR(report.median_px, expected.median_px, kAgreementPx);
  EXPECT_NEAR(report.rms_px, expected.rms_px, kAgreementPx);
  EXPECT_NEAR(report.p95_px, expected.p95_px, kAgreementPx);
  EXPECT_NEAR(report.max_px, expected.max_px, kAgreementPx);
}

CompareReport Compared(const RigCalibration& reference, const RigCalibration& estimate,
                       const std::vector<ComparePoint>& points, CompareAlignment alignment) {
  const auto report = CompareCameras(reference, estimate, points, alignment);
  EXPECT_TRUE(report.has_value()) << (report ? "" : report.error().message);
  return report.value_or(CompareReport{});
}

TEST(CompareCameras, AgreesWithMeasuringToolAfterSimilarity) {
  const CompareReport report =
      Compared(SixCameras(), DisturbedBySines(SixCameras(), 1), LatticePoints(), CompareAlignment::kSimilarity);
  ExpectDistances(report, {6.302989, 5.679074, 6.961108, 12.555076, 14.599433});
  EXPECT_EQ(report.num_views, 6);
  EXPECT_NEAR(report.view_mean_px[0], 4.7554, kAgreementPx);
  EXPECT_NEAR(report.view_mean_px[1], 4.13753, kAgreementPx);
  EXPECT_NEAR(report.centre_relative, 0.006733, 1e-5);
  EXPECT_NEAR(report.rotation_mean_deg, 0.284113, 1e-4);
  EXPECT_NEAR(report.rotation_max_deg, 0.382826, 1e-4);
  EXPECT_NEAR(report.focal_relative, 0.006131, 1e-6);
}

TEST(CompareCameras, AgreesWithMeasuringToolAfterProjectivity) {
  const RigCalibration six = SixCameras();
  ExpectDistances(Compared(six, DisturbedBySines(six, 1), LatticePoints(), CompareAlignment::kProjectivity),
                  {6.125551, 5.318249, 6.923253, 13.224873, 15.318103});
}

TEST(CompareCameras, AgreesWithMeasuringToolOnFarStart) {
  const RigCalibration six = SixCameras(), far = DisturbedBySines(six, 4);
  ExpectDistances(Compared(six, far, LatticePoints(), CompareAlignment::kSimilarity),
                  {25.132834, 22.586003, 27.818396, 50.829476, 59.912928});
  ExpectDistances(Compared(six, far, LatticePoints(), CompareAlignment::kProjectivity),
                  {24.414977, 21.540957, 27.730232, 53.243341, 60.323448});
}

TEST(CompareCameras, AgreesWithMeasuringToolOnRecordedSets) {
  const auto temple = test::ReadRecordedCameras("templeSparseRing", "templeSR_par.txt", 640, 480);
  const auto fountain = test::ReadRecordedCameras("fountain-P11", "fountain-P11_par.txt", 3072, 2048);
  if (!temple || !fountain) GTEST_SKIP() << "RIGCAL_DATA does not hold templeSparseRing and fountain-P11";
  const auto compared = [](const test::RecordedCameras& set, CompareAlignment alignment) {
    return Compared(set.calibration, DisturbedBySines(set.calibration, 1), set.points, alignment);
  };
  ExpectDistances(compared(*temple, CompareAlignment::kSimilarity),
                  {8.996518, 7.60662, 10.014254, 17.600335, 20.550353});
  ExpectDistances(compared(*temple, CompareAlignment::kProjectivity),
                  {8.924254, 7.016907, 9.969437, 17.724839, 21.435576});
  ExpectDistances(compared(*fountain, CompareAlignment::kSimilarity),
                  {29.599452, 25.555719, 34.822339, 65.584226, 172.083526});
  ExpectDistances(compared(*fountain, CompareAlignment::kProjectivity),
                  {29.956794, 25.992755, 35.863489, 66.863764, 191.873758});
}

TEST(CompareCameras, SeesNoDifferenceInAnotherFrame) {
  const RigCalibration six = SixCameras();
  const RigCalibration moved = InFrame(six, 0.01, ExpRotation(Eigen::Vector3d(2, 1, -1)), Eigen::Vector3d(5, 6, 7));
  const CompareReport report = Compared(six, moved, LatticePoints(), CompareAlignment::kSimilarity);
  EXPECT_LT(report.max_px, 1e-6);
  EXPECT_LT(report.centre_relative, 1e-9);
}

TEST(CompareCameras, DistortionOfOneSideOnlyIsSeen) {
  const RigCalibration six = SixCameras();
  RigCalibration distorted = six;
  distorted.cameras[0].k1 = -0.2;
  EXPECT_GT(Compared(six, distorted, LatticePoints(), CompareAlignment::kSimilarity).mean_px, 0.1);
  EXPECT_LT(Compared(distorted, distorted, LatticePoints(), CompareAlignment::kSimilarity).max_px, 1e-6);
}

TEST(CompareCameras, CamerasOnOneLineNeedTheirRotations) {
  RigCalibration line = SixCameras();
  for (int i = 0; i < line.NumViews(); ++i) {
    line.views[i].cam_from_world = test::LookingAt(Eigen::Vector3d(0.3 * i, 2, 0), Eigen::Vector3d::Zero());
  }
  const RigCalibration moved = InFrame(line, 3, ExpRotation(Eigen::Vector3d(0.3, 2.0, 0.4)), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT(Compared(line, moved, LatticePoints(), CompareAlignment::kSimilarity).max_px, 1e-6);
}

TEST(CompareCameras, PairsViewsByNameAndReportsTheirNumber) {
  const RigCalibration six = SixCameras();
  RigCalibration four = six;
  four.views.erase(four.views.begin(), four.views.begin() + 2);
  std::reverse(four.views.begin(), four.views.end());
  const CompareReport report = Compared(six, four, LatticePoints(), CompareAlignment::kSimilarity);
  EXPECT_EQ(report.num_views, 4);
  EXPECT_LT(report.max_px, 1e-6);
}

TEST(CompareCameras, SurvivesPointsBehindCameras) {
  const RigCalibration six = SixCameras();
  std::vector<ComparePoint> points = LatticePoints();
  points.push_back({Eigen::Vector3d(8, 0, 0), {}});
  RigCalibration turned = six;  // one camera of the estimate looks away
  turned.views[3].cam_from_world.rotation =
      ExpRotation(Eigen::Vector3d(0, 3.1, 0)) * turned.views[3].cam_from_world.rotation;
  turned.cameras[0].k1 = 0.1;
  const CompareReport report = Compared(six, turned, points, CompareAlignment::kProjectivity);
  EXPECT_TRUE(std::isfinite(report.mean_px));
  EXPECT_GT(report.mean_px, 1);
}

TEST(CompareCameras, RefusesTooFewCommonViewsAndNoPoints) {
  RigCalibration other = SixCameras();
  for (int i = 1; i < other.NumViews(); ++i) other.views[i].name += "_other";
  const auto no_views = CompareCameras(SixCameras(), other, LatticePoints(), CompareAlignment::kSimilarity);
  ASSERT_FALSE(no_views);
  EXPECT_EQ(no_views.error().code, ErrorCode::kBadInput);
  const auto no_points = CompareCameras(SixCameras(), SixCameras(), {}, CompareAlignment::kSimilarity);
  ASSERT_FALSE(no_points);
  EXPECT_EQ(no_points.error().code, ErrorCode::kBadInput);
}

TEST(SpreadPoints, FillTheSharedVolumeAndNameTheirViews) {
  const RigCalibration six = SixCameras();
  const auto points = SpreadPoints(six);
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_GE(points->size(), 700u);
  EXPECT_LE(points->size(), 1728u);
  Eigen::AlignedBox3d box;
  for (const ComparePoint& p : *points) {
    box.extend(p.x_in_world);
    EXPECT_GE(p.views.size(), 2u);
    for (int j = 0; j < six.NumViews(); ++j) {
      const auto x_px = Project(six.cameras[0], six.views[j].cam_from_world * p.x_in_world);
      const bool in_picture = x_px && (x_px->array() >= 0).all() && x_px->x() <= 639 && x_px->y() <= 479;
      EXPECT_EQ(std::count(p.views.begin(), p.views.end(), j), in_picture ? 1 : 0);
    }
  }
  // 640 px at 1000 px and 2.0-2.2 m take in 0.6-0.7 m each way.
  EXPECT_TRUE(box.contains(Eigen::Vector3d(0.3, 0.3, 0.3)));
  EXPECT_TRUE(box.contains(Eigen::Vector3d(-0.3, -0.3, -0.3)));
  EXPECT_LT(box.sizes().maxCoeff(), 2.0);
}

TEST(SpreadPoints, ParallelCamerasShareTheVolumeBeforeThem) {
  RigCalibration parallel = SixCameras();
  parallel.views.resize(2);
  parallel.views[0].cam_from_world = {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 0)};
  parallel.views[1].cam_from_world = {Eigen::Quaterniond::Identity(), Eigen::Vector3d(-0.5, 0, 0)};
  const auto points = SpreadPoints(parallel);
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_GE(points->size(), 100u);
}

TEST(SpreadPoints, RefusesCamerasThatShareNothing) {
  RigCalibration apart = SixCameras();
  apart.views.resize(2);
  apart.views[0].cam_from_world = test::LookingAt(Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(9, 1, 0));
  apart.views[1].cam_from_world = test::LookingAt(Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(-9, 0, 0));
  const auto points = SpreadPoints(apart);
  ASSERT_FALSE(points);
  EXPECT_EQ(points.error().code, ErrorCode::kBadInput);
}

}  // namespace
}  // namespace rigcal
