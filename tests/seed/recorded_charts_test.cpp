#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/seed/corner_place.h"
#include "core/seed/detect_chart.h"
#include "tests/support/middlebury_set.h"

namespace rigcal {
namespace {

using CornersOfTag = std::map<int, Eigen::Vector2d>;
using TagsOfPicture = std::map<int, CornersOfTag>;

// Rows: ts, tag_rows, tag_cols, tag_size, tag_spacing, kp_x, kp_y, p_x, p_y, p_z, tag_id, corner_idx. Corners in the
// order of TagCornerInBoard.
TagsOfPicture ReadYacCorners(const std::filesystem::path& path) {
  TagsOfPicture tags;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::stringstream fields(line);
    std::vector<double> values;
    for (std::string field; std::getline(fields, field, ',');) values.push_back(std::stod(field));
    tags[static_cast<int>(values[10])][static_cast<int>(values[11])] = {values[5], values[6]};
  }
  return tags;
}

struct YacView {
  ChartDetection ours;
  TagsOfPicture theirs;
};

Board YacBoard() {
  return {.border_bits = 2, .columns = 6, .rows = 6, .tag_m = 0.088, .gap_m = 0.0264};
}

std::vector<YacView> SeeYac(const std::filesystem::path& set) {
  std::vector<std::filesystem::path> pictures;
  for (const auto& entry : std::filesystem::directory_iterator(set / "mocap_data/cam0/data")) pictures.push_back(entry);
  std::sort(pictures.begin(), pictures.end());
  std::vector<YacView> views;
  for (const auto& path : pictures) {
    cv::Mat1f picture;
    cv::imread(path.string(), cv::IMREAD_GRAYSCALE).convertTo(picture, CV_32F, 1.0 / 255);
    const Result<ChartDetection> seen = DetectChart(picture, YacBoard());
    EXPECT_TRUE(seen);
    const auto corners = set / "mocap_data/grid0/cam0/data" / (path.stem().string() + ".csv");
    views.push_back({*seen, ReadYacCorners(corners)});
  }
  return views;
}

struct PlainCalibration {
  double rms_px = 0, worst_px = 0;
  cv::Matx33d intrinsics;
};

// As OpenCV calibrates without being told anything.
template <typename CornersOfView>
PlainCalibration Calibrate(const std::vector<YacView>& views, const CornersOfView& corners_of) {
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> in_picture;
  for (const YacView& view : views) {
    on_board.emplace_back(), in_picture.emplace_back();
    corners_of(view, [&](int tag, int corner, const Eigen::Vector2d& x_px) {
      const Eigen::Vector3f x_m = TagCornerInBoard(YacBoard(), tag, corner).cast<float>();
      on_board.back().emplace_back(x_m.x(), x_m.y(), x_m.z());
      in_picture.back().emplace_back(static_cast<float>(x_px.x()), static_cast<float>(x_px.y()));
    });
  }
  PlainCalibration result;
  cv::Mat distortion;
  std::vector<cv::Mat> rotations, translations;
  result.rms_px =
      cv::calibrateCamera(on_board, in_picture, {640, 480}, result.intrinsics, distortion, rotations, translations);
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<cv::Point2f> projected;
    cv::projectPoints(on_board[v], rotations[v], translations[v], result.intrinsics, distortion, projected);
    for (std::size_t i = 0; i < projected.size(); ++i)
      result.worst_px = std::max(result.worst_px, cv::norm(projected[i] - in_picture[v][i]));
  }
  return result;
}

TEST(RecordedCharts, KalibrGridOfYac) {
  const auto sets = RecordedSets();
  if (!sets || !std::filesystem::exists(*sets / "yac-aprilgrid")) GTEST_SKIP() << "RIGCAL_DATA has no yac-aprilgrid";
  const std::vector<YacView> views = SeeYac(*sets / "yac-aprilgrid");
  ASSERT_EQ(views.size(), 30U);
  int listed = 0, found = 0;
  for (const YacView& view : views) {
    for (const auto& [tag, corners] : view.theirs) {
      ++listed;
      found += std::any_of(view.ours.corners.begin(), view.ours.corners.end(),
                           [id = tag](const ChartCorner& corner) { return corner.tag_id == id; });
    }
  }
  EXPECT_EQ(listed, 1007);
  EXPECT_GE(found, 1003);  // 1006 measured
  const PlainCalibration ours = Calibrate(views, [](const YacView& view, const auto& add) {
    for (const ChartCorner& corner : view.ours.corners) add(corner.tag_id, corner.corner, corner.x_px);
  });
  const PlainCalibration theirs = Calibrate(views, [](const YacView& view, const auto& add) {
    for (const auto& [tag, corners] : view.theirs)
      for (const auto& [corner, x_px] : corners) add(tag, corner, x_px);
  });
  EXPECT_NEAR(theirs.rms_px, 0.294, 0.002);
  EXPECT_LT(ours.rms_px, 0.22);   // 0.206 measured
  EXPECT_LT(ours.worst_px, 1.5);  // no tag is wrong: the next one is 10 px away
  EXPECT_NEAR(ours.intrinsics(0, 0) / theirs.intrinsics(0, 0), 1, 0.005);
  EXPECT_NEAR(ours.intrinsics(1, 1) / theirs.intrinsics(1, 1), 1, 0.005);
  EXPECT_NEAR(ours.intrinsics(0, 2), theirs.intrinsics(0, 2), 3);
  EXPECT_NEAR(ours.intrinsics(1, 2), theirs.intrinsics(1, 2), 3);
}

// ---- ViSP's rendered tags: each of five tags of eight families at a known pose, camera f = 700 px, axis in the middle
// of 640 x 480 pixels. cMo_N.txt are the true poses. corners_*.txt repeat what libapriltag reports (to 0.01 px), with
// its origin at the pixel's corner.

struct VispFamily {
  const char* file;
  const char* name;
  double edge_share;  ///< of the printed square's 0.25 m (tags 0-2) or 0.125 m (tags 3, 4)
};
constexpr std::array<VispFamily, 8> kVispFamilies = {{{"tag16_05", "tag16h5", 6 / 8.0},
                                                      {"tag21_07", "tagCircle21h7", 5 / 9.0},
                                                      {"tag25_09", "tag25h9", 7 / 9.0},
                                                      {"tag36_11", "tag36h11", 8 / 10.0},
                                                      {"tag41_12", "tagStandard41h12", 5 / 9.0},
                                                      {"tag48_12", "tagCustom48h12", 6 / 10.0},
                                                      {"tag49_12", "tagCircle49h12", 5 / 11.0},
                                                      {"tag52_13", "tagStandard52h13", 6 / 10.0}}};

Eigen::Vector2d VispCorner(const std::filesystem::path& folder, const VispFamily& family, int tag, int corner) {
  std::ifstream file(folder / fmt::format("cMo_{}.txt", tag));
  Eigen::Matrix4d cam_from_tag;
  for (int i = 0; i < 16; ++i) file >> cam_from_tag(i / 4, i % 4);
  const double half_m = (tag < 3 ? 0.25 : 0.125) * family.edge_share / 2;
  const Eigen::Vector4d x_in_tag(corner == 1 || corner == 2 ? half_m : -half_m, corner >= 2 ? half_m : -half_m, 0, 1);
  const Eigen::Vector4d x_in_cam = cam_from_tag * x_in_tag;
  return 700 * x_in_cam.head<2>() / x_in_cam.z() + Eigen::Vector2d(319.5, 239.5);
}

std::map<int, std::array<Eigen::Vector2d, 4>> VispListedCorners(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::map<int, std::array<Eigen::Vector2d, 4>> tags;
  for (int tag = 0; file >> tag;)
    for (Eigen::Vector2d& corner : tags[tag]) file >> corner.x() >> corner.y();
  return tags;
}

TEST(RecordedCharts, RenderedTagsOfVisp) {
  const auto sets = RecordedSets();
  if (!sets || !std::filesystem::exists(*sets / "visp-apriltag-gt"))
    GTEST_SKIP() << "RIGCAL_DATA has no visp-apriltag-gt";
  const std::filesystem::path folder = *sets / "visp-apriltag-gt/benchmark/640x480";
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), listed_mean = Eigen::Vector2d::Zero();
  double square = 0, found_square = 0;
  int corners = 0;
  for (const VispFamily& visp : kVispFamilies) {
    const Result<TagFamily> family = TagFamily::Make(visp.name, 1);
    ASSERT_TRUE(family);
    const cv::Mat1b bits =
        cv::imread((folder / fmt::format("{}_640x480.png", visp.file)).string(), cv::IMREAD_GRAYSCALE);
    cv::Mat1f picture;
    bits.convertTo(picture, CV_32F, 1.0 / 255);
    const auto listed = VispListedCorners(folder / fmt::format("corners_{}.txt", visp.file));
    const std::vector<FoundTag> tags = FindTags(bits, *family);
    ASSERT_EQ(tags.size(), 5U) << visp.name;
    for (const FoundTag& tag : tags) {
      for (int k = 0; k < kCornersPerTag; ++k) {
        // The renderer filters its textures in encoded values.
        const auto refined = RefineCorner({picture, true}, PlaceOfCorner(*family, tag, k, 1));
        ASSERT_TRUE(refined) << visp.name << " " << tag.id;
        const Eigen::Vector2d error = refined->x_px - VispCorner(folder, visp, tag.id, k);
        mean += error, square += error.squaredNorm() / 2, ++corners;
        found_square += (tag.corners_px[k] - VispCorner(folder, visp, tag.id, k)).squaredNorm() / 2;
        listed_mean += tag.corners_px[k] - listed.at(tag.id)[k];
      }
    }
  }
  mean /= corners, listed_mean /= corners;
  // Both texts at once: by the poses the origin is the pixel's centre, by libapriltag's own list it is its corner.
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.25) << mean.transpose();  // -0.14, -0.01 measured; half a pixel off otherwise
  EXPECT_NEAR(listed_mean.x(), -0.5, 0.02);
  EXPECT_NEAR(listed_mean.y(), -0.5, 0.02);
  // The renderer's mip-mapped textures are off by a third of a pixel, for every detector.
  EXPECT_LT(std::sqrt(square / corners), 0.33);           // 0.287 measured
  EXPECT_LT(std::sqrt(square), std::sqrt(found_square));  // 0.304 for libapriltag's own corners
}

}  // namespace
}  // namespace rigcal
