#include "config/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <sstream>

#include "config/load_cameras.h"
#include "config/read_file.h"
#include "core/base/random.h"
#include "tests/config/example_rig.h"
#include "tests/config/export_examples.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

RigCalibration WithDistortion(double k3) {
  RigCalibration ring = ExampleRing(5);
  Camera& camera = ring.cameras[0];
  camera.k1 = -0.1 / 3, camera.k2 = 0.02 / 7, camera.p1 = 1e-3 / 3, camera.p2 = -1e-3 / 7, camera.k3 = k3;
  return ring;
}

/// Points of the object, to be projected by an independent reader of the format.
std::vector<Eigen::Vector3d> ObjectPoints() {
  std::vector<Eigen::Vector3d> points;
  Random random(11);
  for (int i = 0; i < 1000; ++i)
    points.emplace_back(random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1));
  return points;
}

Eigen::Vector2d OwnProjection(const RigCalibration& calibration, int v, const Eigen::Vector3d& x_in_world) {
  return *Project(calibration.CameraOf(v), calibration.views[v].cam_from_world * x_in_world);
}

TEST(Export, MiddleburyReadByAMatrixProduct) {
  const TemporaryFolder folder;
  const RigCalibration ring = ExampleRing(5);
  const auto path = folder.Path() / "cams_par.txt";
  ASSERT_TRUE(Export(ring, {ExportFormat::kMiddlebury}, path));
  std::ifstream file(path);
  int count = 0;
  file >> count;
  ASSERT_EQ(count, 5);
  for (int v = 0; v < count; ++v) {
    std::string name;
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> k, r;
    Eigen::Vector3d t;
    file >> name;
    for (double* number = k.data(); number != k.data() + 9; ++number) file >> *number;
    for (double* number = r.data(); number != r.data() + 9; ++number) file >> *number;
    file >> t[0] >> t[1] >> t[2];
    EXPECT_EQ(name, ring.views[v].name);
    EXPECT_EQ(k(0, 0), ring.cameras[0].fx_px);  // 17 digits bring back the same double
    EXPECT_EQ(k(1, 2), ring.cameras[0].cy_px);
    for (const Eigen::Vector3d& point : ObjectPoints())
      EXPECT_LT(((k * (r * point + t)).hnormalized() - OwnProjection(ring, v, point)).norm(), 1e-9);
  }
}

/// A reader of COLMAP's text written from its documentation: quaternion w x y z, origin at the pixel's corner.
Eigen::Vector2d ColmapProjection(const std::vector<double>& parameters, const std::vector<double>& pose,
                                 const Eigen::Vector3d& x_in_world) {
  const double w = pose[0], x = pose[1], y = pose[2], z = pose[3];
  Eigen::Matrix3d r;
  r << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
      2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  const Eigen::Vector3d x_in_cam = r * x_in_world + Eigen::Vector3d(pose[4], pose[5], pose[6]);
  const Eigen::Vector2d n = x_in_cam.head<2>() / x_in_cam.z();
  const double r2 = n.squaredNorm();
  const auto at = [&](std::size_t i) { return i < parameters.size() ? parameters[i] : 0.0; };
  const double radial = 1 + at(4) * r2 + at(5) * r2 * r2 + at(8) * r2 * r2 * r2;
  const double dx = 2 * at(6) * n.x() * n.y() + at(7) * (r2 + 2 * n.x() * n.x());
  const double dy = 2 * at(7) * n.x() * n.y() + at(6) * (r2 + 2 * n.y() * n.y());
  return {at(0) * (n.x() * radial + dx) + at(2), at(1) * (n.y() * radial + dy) + at(3)};
}

class ExportColmap : public ::testing::TestWithParam<std::pair<RigCalibration, std::string>> {};

TEST_P(ExportColmap, ProjectsHalfAPixelAway) {
  const auto& [ring, expected_model] = GetParam();
  const TemporaryFolder folder;
  ASSERT_TRUE(Export(ring, {ExportFormat::kColmap}, folder.Path() / "model"));
  std::string line, model, id;
  std::ifstream cameras(folder.Path() / "model" / "cameras.txt"), images(folder.Path() / "model" / "images.txt");
  ASSERT_TRUE(std::filesystem::exists(folder.Path() / "model" / "points3D.txt"));
  std::getline(cameras, line), std::getline(cameras, line);
  int width = 0, height = 0;
  std::istringstream camera_line(line);
  camera_line >> id >> model >> width >> height;
  EXPECT_EQ(model, expected_model);
  EXPECT_EQ(width, 64);
  const std::vector<double> parameters{std::istream_iterator<double>(camera_line), {}};
  std::getline(images, line), std::getline(images, line);
  for (int v = 0; v < ring.NumViews(); ++v) {
    std::getline(images, line);
    std::istringstream image_line(line);
    std::vector<double> numbers(9);
    for (double& number : numbers) image_line >> number;
    std::string name;
    image_line >> name;
    EXPECT_EQ(name, ring.views[v].name);
    EXPECT_EQ(numbers[8], std::stoi(id));
    for (const Eigen::Vector3d& point : ObjectPoints()) {
      const Eigen::Vector2d corner = ColmapProjection(parameters, {numbers.begin() + 1, numbers.begin() + 8}, point);
      EXPECT_LT((corner - Eigen::Vector2d(0.5, 0.5) - OwnProjection(ring, v, point)).norm(), 1e-9);
    }
    std::getline(images, line);
    EXPECT_EQ(line, "");
  }
}

INSTANTIATE_TEST_SUITE_P(Models, ExportColmap,
                         ::testing::Values(std::pair(ExampleRing(5), "PINHOLE"), std::pair(WithDistortion(0), "OPENCV"),
                                           std::pair(WithDistortion(0.01), "FULL_OPENCV")));

TEST(Export, ColmapComesBackThroughLoadCameras) {
  const TemporaryFolder folder;
  const RigCalibration ring = WithDistortion(0.01);
  ASSERT_TRUE(Export(ring, {ExportFormat::kColmap}, folder.Path()));
  const auto loaded = LoadCameras(folder.Path(), {});
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_LT((loaded->calibration.cameras[0].Intrinsics() - ring.cameras[0].Intrinsics()).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Export, PmvsIsANormalisedMatrix) {
  const TemporaryFolder folder;
  const RigCalibration ring = ExampleRing(5);
  ASSERT_TRUE(Export(ring, {ExportFormat::kPmvs}, folder.Path()));
  for (int v = 0; v < ring.NumViews(); ++v) {
    std::ifstream file(folder.Path() / "txt" / fmt::format("{:08d}.txt", v));
    std::string keyword;
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> p;
    file >> keyword;
    for (double* number = p.data(); number != p.data() + 12; ++number) file >> *number;
    EXPECT_EQ(keyword, "CONTOUR");
    EXPECT_NEAR((p.block<1, 3>(2, 0).norm()), 1, 1e-15);
    for (const Eigen::Vector3d& point : ObjectPoints()) {
      const Eigen::Vector3d projected = p * point.homogeneous();
      EXPECT_GT(projected.z(), 0);  // in front is positive
      EXPECT_LT((projected.hnormalized() - OwnProjection(ring, v, point)).norm(), 1e-9);
    }
  }
}

TEST(Export, OpenCvReadByOpenCv) {
  const TemporaryFolder folder;
  const RigCalibration ring = WithDistortion(0.01);
  const auto path = folder.Path() / "cameras.yml";
  ASSERT_TRUE(Export(ring, {ExportFormat::kOpenCv}, path));
  const cv::FileStorage file(path.string(), cv::FileStorage::READ);
  const cv::FileNode cameras = file["cameras"], views = file["views"];
  ASSERT_EQ(views.size(), 5U);
  EXPECT_EQ(static_cast<int>(cameras[0]["image_width"]), 64);
  std::vector<cv::Point3d> points;
  for (const Eigen::Vector3d& point : ObjectPoints()) points.emplace_back(point.x(), point.y(), point.z());
  for (int v = 0; v < 5; ++v) {
    const cv::FileNode camera = cameras[static_cast<int>(views[v]["camera"])];
    cv::Mat k, distortion, rvec, tvec;
    camera["camera_matrix"] >> k, camera["distortion_coefficients"] >> distortion;
    views[v]["rvec"] >> rvec, views[v]["tvec"] >> tvec;
    EXPECT_EQ(static_cast<std::string>(views[v]["name"]), ring.views[v].name);
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, rvec, tvec, k, distortion, pixels);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d own = OwnProjection(ring, v, {points[i].x, points[i].y, points[i].z});
      EXPECT_LT((Eigen::Vector2d(pixels[i].x, pixels[i].y) - own).norm(), 1e-9);
    }
  }
}

/// How a calibration is changed so that it holds what one gap is about.
void Spoil(Gap gap, RigCalibration& ring) {
  Camera& camera = ring.cameras[0];
  if (gap == kNoDistortion) camera.k1 = 0.01;
  if (gap == kNoTangential) camera.p1 = 0.01;
  if (gap == kNoK3) camera.k3 = 0.01;
  if (gap == kNoSkew) camera.skew_px = 1;
  if (gap == kOneFocalLength) camera.fy_px = camera.fx_px + 1;
  if (gap == kCentred) camera.cx_px += 1;
  if (gap == kNamesAreWords) ring.views[1].name = "a b.png";
  if (gap == kNeedsSize) camera.width_px = 0;
}

/// What every format can hold: square pixels, a centred axis, no distortion.
RigCalibration PlainRing() {
  RigCalibration ring = ExampleRing(3);
  Camera& camera = ring.cameras[0];
  camera.fy_px = camera.fx_px, camera.cx_px = 31.5, camera.cy_px = 23.5;
  return ring;
}

class EveryFormat : public ::testing::TestWithParam<FormatEntry> {};

TEST_P(EveryFormat, RefusesWhatItCannotSayAndWritesTheRest) {
  const FormatEntry& entry = GetParam();
  const TemporaryFolder folder;
  EXPECT_EQ(Message(Export(PlainRing(), {entry.format}, folder.Path() / "plain")), kNoError);
  for (Gap gap :
       {kNoDistortion, kNoTangential, kNoK3, kNoSkew, kOneFocalLength, kCentred, kNamesAreWords, kNeedsSize}) {
    RigCalibration ring = PlainRing();
    Spoil(gap, ring);
    const bool any_distortion = (gap == kNoTangential || gap == kNoK3) && (entry.gaps & kNoDistortion) != 0;
    // The middle of a picture needs its size.
    const bool refused =
        (entry.gaps & gap) != 0 || any_distortion || (gap == kNeedsSize && (entry.gaps & kCentred) != 0);
    const auto out = folder.Path() / fmt::format("{}", static_cast<unsigned>(gap));
    const auto written = Export(ring, {entry.format}, out);
    EXPECT_EQ(written.has_value(), !refused) << entry.name << " " << gap << ": " << Message(written);
    EXPECT_EQ(std::filesystem::exists(out), !refused) << entry.name << " " << gap;
    if (refused && gap != kNeedsSize) {
      EXPECT_EQ(written.error().code, ErrorCode::kUnsupported);
      EXPECT_THAT(written.error().message, HasSubstr(std::string(entry.title)));
    }
  }
}

TEST_P(EveryFormat, HoldsUndistortedCamerasOnRequest) {
  const FormatEntry& entry = GetParam();
  const TemporaryFolder folder;
  const auto out = folder.Path() / "out";
  RigCalibration ring = WithDistortion(0.01);
  const auto notes = Export(ring, {entry.format, true}, out);
  ASSERT_TRUE(notes) << Message(notes);
  EXPECT_THAT(*notes, Contains(HasSubstr("not the photographs")));
  EXPECT_EQ(std::filesystem::exists(out / "undistort.yml"), (entry.gaps & (kOneFocalLength | kCentred)) != 0);
  ring.cameras[0].skew_px = 1;  // cannot be undistorted away
  EXPECT_EQ(Export(ring, {entry.format, true}, folder.Path() / "skewed").has_value(), (entry.gaps & kNoSkew) == 0);
}

TEST_P(EveryFormat, TakesThePlaceOfItsOwnExportAndOfNothingElse) {
  const FormatEntry& entry = GetParam();
  const TemporaryFolder folder;
  const auto out = folder.Path() / "out";
  EXPECT_EQ(Message(Export(PlainRing(), {entry.format}, out)), kNoError);
  EXPECT_EQ(Message(Export(PlainRing(), {entry.format}, out)), kNoError);
  const FormatEntry& other =
      EntryOf(entry.format == ExportFormat::kOpenCv ? ExportFormat::kKalibr : ExportFormat::kOpenCv);
  EXPECT_THAT(Message(Export(PlainRing(), {other.format}, out)), HasSubstr((folder.Path() / "out").string()));
  const auto mine = folder.Write("mine", "cam0: by hand\n");
  EXPECT_THAT(Message(Export(PlainRing(), {entry.format}, mine)), HasSubstr(mine.string()));
  EXPECT_EQ(*ReadFile(mine), "cam0: by hand\n");
  int left = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder.Path())) left += file.exists();
  EXPECT_EQ(left, 2);  // "out" and "mine", nothing temporary
}

TEST_P(EveryFormat, WritesTheSameBytesAgain) {
  const TemporaryFolder folder;
  const RigCalibration ring = PlainRing();
  const auto first = GetParam().files(ring), second = GetParam().files(ring);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryFormat, ::testing::ValuesIn(ExportFormats().begin(), ExportFormats().end()));

TEST(Export, NamesTheWayOut) {
  const TemporaryFolder folder;
  for (ExportFormat format : {ExportFormat::kMiddlebury, ExportFormat::kPmvs, ExportFormat::kBundler}) {
    EXPECT_THAT(Message(Export(WithDistortion(0.01), {format}, folder.Path() / "out")), HasSubstr("--undistorted"));
  }
  EXPECT_THAT(Message(Export(ExampleRing(3), {ExportFormat::kOpenCv}, "/proc/rigcal/out.yml")),
              HasSubstr("/proc/rigcal"));
}

TEST(Export, NamesDoNotLeadOutOfTheFolder) {
  const TemporaryFolder folder;
  for (const char* name : {"../out.png", "/tmp/out.png", "a/../../out.png", "./out.png"}) {
    RigCalibration ring = PlainRing();
    ring.views[1].name = name;
    ring.cameras[0].id = name;
    for (ExportFormat format : {ExportFormat::kMrcal, ExportFormat::kRealityCapture, ExportFormat::kRos}) {
      const auto written = Export(ring, {format}, folder.Path() / "in" / "out");
      ASSERT_FALSE(written) << name;
      EXPECT_EQ(written.error().code, ErrorCode::kUnsupported) << Message(written);
    }
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
  RigCalibration ring = PlainRing();
  ring.views[1].name = "left/1.png";
  ASSERT_EQ(Message(Export(ring, {ExportFormat::kMrcal}, folder.Path() / "out")), kNoError);
  EXPECT_TRUE(std::filesystem::exists(folder.Path() / "out" / "left" / "1.cameramodel"));
}

TEST(Export, TwoImagesOfOneStemAreRefused) {
  const TemporaryFolder folder;
  RigCalibration ring = PlainRing();
  ring.views[1].name = "ring_00.jpg";
  for (ExportFormat format : {ExportFormat::kMrcal, ExportFormat::kRealityCapture})
    EXPECT_THAT(Message(Export(ring, {format}, folder.Path() / "out")),
                AllOf(HasSubstr("ring_00.jpg"), HasSubstr("ring_00.png")));
}

TEST(Export, KalibrNeedsCamerasThatAreFixedToEachOther) {
  const TemporaryFolder folder;
  RigCalibration studio = ExportExamples().at("no_k3");
  EXPECT_EQ(Message(Export(studio, {ExportFormat::kKalibr}, folder.Path() / "rig")), kNoError);
  RigCalibration unmounted = studio;
  unmounted.rig->model.cam_from_mount[1].reset();
  EXPECT_THAT(Message(Export(unmounted, {ExportFormat::kKalibr}, folder.Path() / "out")), HasSubstr("'right'"));
  studio.rig.reset();
  EXPECT_THAT(Message(Export(studio, {ExportFormat::kKalibr}, folder.Path() / "out")), HasSubstr("no rig"));
  studio.views.resize(3);  // one picture of each camera
  ASSERT_EQ(Message(Export(studio, {ExportFormat::kKalibr}, folder.Path() / "snapshot")), kNoError);
  EXPECT_THAT(*ReadFile(folder.Path() / "snapshot"), HasSubstr("cam2:"));
}

TEST(Export, FormatNames) {
  for (const FormatEntry& entry : ExportFormats()) {
    EXPECT_EQ(ExportFormatFromName(entry.name), entry.format);
    EXPECT_EQ(&EntryOf(entry.format), &entry);
  }
  EXPECT_FALSE(ExportFormatFromName("nvm"));
}

TEST(Export, TheDocumentationHasTheTable) {
  const Result<std::string> text = ReadFile(std::filesystem::path(RIGCAL_SCHEMA_DIR).parent_path() / "formats.md");
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, HasSubstr(FormatTableText())) << "docs/formats.md is to have these rows";
}

}  // namespace
}  // namespace rigcal
