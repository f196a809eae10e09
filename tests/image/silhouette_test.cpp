#include "core/image/silhouette.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "sim_fixtures/render.h"

namespace rigcal {
namespace {

/// Pictures of one camera and what is object in them.
struct Shots {
  std::vector<cv::Mat1f> pictures;
  std::vector<cv::Mat1b> truth;
};

double IntersectionOverUnion(const cv::Mat1b& a, const cv::Mat1b& b) {
  cv::Mat1b both, either;
  cv::bitwise_and(a, b, both);
  cv::bitwise_or(a, b, either);
  return cv::countNonZero(both) / static_cast<double>(cv::countNonZero(either));
}

Shots Render(sim::Scene scene, sim::Surroundings surroundings, sim::Motion motion) {
  sim::StudioOptions options;
  options.scene = scene;
  options.motion = motion;
  options.surroundings = surroundings;
  options.num_stops = options.num_views = 10;
  options.width_px = 400;
  options.height_px = 300;
  options.cell_m = 0.003;
  const auto studio = sim::MakeStudio(options, {});
  Shots shots;
  for (int view = 0; view < studio->truth.NumViews(); ++view) {
    const auto rendered = sim::RenderView(*studio, view, 2, {});
    cv::Mat1f picture;
    sim::Expose(rendered->radiance, {}, static_cast<std::uint64_t>(view)).convertTo(picture, CV_32F, 1.0 / 255);
    shots.pictures.push_back(picture);
    shots.truth.push_back(sim::MaskOf(*rendered));
  }
  return shots;
}

void ExpectFound(const Shots& shots, Background background, double least_iou) {
  const Silhouettes found = FindSilhouettes(shots.pictures, Execution{});
  ASSERT_EQ(found.background, background);
  ASSERT_EQ(found.masks.size(), shots.pictures.size());
  for (std::size_t i = 0; i < shots.pictures.size(); ++i) {
    EXPECT_GT(IntersectionOverUnion(found.masks[i], shots.truth[i]), least_iou) << "picture " << i;
    const double share = cv::countNonZero(found.masks[i]) / static_cast<double>(found.masks[i].total());
    EXPECT_NEAR(found.object_share[i], share, 1e-12);
  }
}

/// For parts that are only a few pixels thick, where a pixel along the rim decides over the intersection: nothing of
/// the object is lost, and what is too much lies within `rim_px` of it.
void ExpectWithinRim(const Shots& shots, Background background, int rim_px) {
  constexpr double kMaxLost = 0.005, kMaxBeyondRim = 0.005;
  const Silhouettes found = FindSilhouettes(shots.pictures, Execution{});
  ASSERT_EQ(found.background, background);
  for (std::size_t i = 0; i < shots.pictures.size(); ++i) {
    const cv::Mat1b& truth = shots.truth[i];
    cv::Mat1b grown;
    cv::dilate(truth, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * rim_px + 1, 2 * rim_px + 1}));
    EXPECT_LT(cv::countNonZero(truth & ~found.masks[i]), kMaxLost * cv::countNonZero(truth)) << "picture " << i;
    EXPECT_LT(cv::countNonZero(found.masks[i] & ~grown), kMaxBeyondRim * cv::countNonZero(truth)) << "picture " << i;
  }
}

TEST(FindSilhouettes, DarkClothBehindEveryKindOfObject) {
  using enum sim::Scene;
  ExpectFound(Render(kTextured, sim::Surroundings::kBlack, sim::Motion::kTurntable), Background::kDark, 0.93);
  ExpectFound(Render(kPlaster, sim::Surroundings::kBlack, sim::Motion::kTurntable), Background::kDark, 0.93);
  ExpectWithinRim(Render(kThin, sim::Surroundings::kBlack, sim::Motion::kGantry), Background::kDark, 2);
}

TEST(FindSilhouettes, StaticBackdropBehindATurningTable) {
  using enum sim::Scene;
  ExpectFound(Render(kTextured, sim::Surroundings::kBackdrop, sim::Motion::kTurntable), Background::kStatic, 0.93);
  ExpectFound(Render(kPlaster, sim::Surroundings::kBackdrop, sim::Motion::kTurntable), Background::kStatic, 0.93);
}

void ExpectNone(const std::vector<cv::Mat1f>& pictures) {
  const Silhouettes found = FindSilhouettes(pictures, Execution{});
  EXPECT_EQ(found.background, Background::kNone);
  ASSERT_EQ(found.masks.size(), pictures.size());
  for (const cv::Mat1b& mask : found.masks) EXPECT_TRUE(mask.empty());
  EXPECT_EQ(found.object_share, std::vector<double>(pictures.size(), 1.0));
}

TEST(FindSilhouettes, NoneWhenTheCameraMovesBeforeABackdrop) {
  ExpectNone(Render(sim::Scene::kTextured, sim::Surroundings::kBackdrop, sim::Motion::kGantry).pictures);
}

TEST(FindSilhouettes, NoneForPicturesWithoutContent) {
  ExpectNone({});
  ExpectNone(std::vector<cv::Mat1f>(8, cv::Mat1f(60, 80, 0.0f)));
  ExpectNone(std::vector<cv::Mat1f>(8, cv::Mat1f(60, 80, 0.5f)));
}

/// Photographs that nobody of this project made (README of the data): skipped where they are absent.
class RecordedSilhouettes : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("RIGCAL_DATA");
    if (folder == nullptr) GTEST_SKIP() << "RIGCAL_DATA is not set";
    data_ = folder;
  }
  [[nodiscard]] std::vector<cv::Mat1f> Read(const std::string& pattern) const {
    std::vector<cv::String> files;
    cv::glob((data_ / pattern).string(), files);
    std::vector<cv::Mat1f> pictures;
    for (const cv::String& file : files) {
      cv::Mat1f picture;
      cv::imread(file, cv::IMREAD_GRAYSCALE).convertTo(picture, CV_32F, 1.0 / 255);
      pictures.push_back(picture);
    }
    return pictures;
  }
  std::filesystem::path data_;
};

TEST_F(RecordedSilhouettes, TempleStandsBeforeDarkCloth) {
  const Silhouettes found = FindSilhouettes(Read("templeSparseRing/*.png"), Execution{});
  ASSERT_EQ(found.background, Background::kDark);
  for (const double share : found.object_share) EXPECT_NEAR(share, 0.2, 0.12);
}

TEST_F(RecordedSilhouettes, SquirrelAgreesWithTheContoursDrawnByHand) {
  const Silhouettes found = FindSilhouettes(Read("squirrel-turntable/image_*.jpg"), Execution{});
  ASSERT_NE(found.background, Background::kNone);
  for (const int picture : {0, 9, 20, 33}) {
    const auto file = data_ / "squirrel-turntable/silhouettes" / ("contour_" + std::to_string(picture) + ".jpg");
    const cv::Mat1b drawn = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    cv::Mat1b object;
    cv::compare(drawn, 128, object, cv::CMP_GE);
    EXPECT_GT(IntersectionOverUnion(found.masks[picture], object), 0.9) << "picture " << picture;
  }
}

TEST_F(RecordedSilhouettes, FountainHasNone) {
  EXPECT_EQ(FindSilhouettes(Read("fountain-P11/*.jpg"), Execution{}).background, Background::kNone);
}

}  // namespace
}  // namespace rigcal
