#include "config/load_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/config/example_rig.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;

const cv::Size kSize(64, 48);  // of ExampleRing

void WriteImage(const std::filesystem::path& path, const cv::Mat& image) {
  std::filesystem::create_directories(path.parent_path());
  ASSERT_TRUE(cv::imwrite(path.string(), image));
}

/// Four views of a ring with a smooth picture each, and masks in masks/.
class LoadImagesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const View& view : ring_.views) {
      WriteImage(folder_.Path() / view.name, Picture());
      WriteImage(Mask(view.name), Half());
    }
  }

  /// Grey 2 x + y.
  static cv::Mat Picture() {
    cv::Mat1b picture(kSize);
    for (int y = 0; y < picture.rows; ++y)
      for (int x = 0; x < picture.cols; ++x) picture(y, x) = static_cast<unsigned char>(2 * x + y);
    return picture;
  }
  /// The left half is object.
  static cv::Mat Half() {
    cv::Mat1b half(kSize, 127);
    half.colRange(0, kSize.width / 2) = 128;
    return half;
  }
  [[nodiscard]] std::filesystem::path Mask(const std::string& name) const { return folder_.Path() / "masks" / name; }

  Result<LoadedImages> Load(ImageOptions options = {.masks = MaskSource::kNone}, int num_threads = 2) {
    return LoadImages(folder_.Path(), ring_, options, {.num_threads = num_threads});
  }
  [[nodiscard]] ImageOptions WithMasks() const {
    return {.masks = MaskSource::kFolder, .mask_folder = folder_.Path() / "masks"};
  }

  TemporaryFolder folder_;
  RigCalibration ring_ = ExampleRing(4);
};

TEST_F(LoadImagesTest, GrayPyramidColoursAndHashes) {
  ring_.cameras[0].width_px = ring_.cameras[0].height_px = 0;
  const auto loaded = Load({.num_levels = 3, .colour_level = 1, .masks = MaskSource::kNone});
  ASSERT_TRUE(loaded) << Message(loaded);
  ASSERT_EQ(loaded->images.NumViews(), 4);
  const ViewImages& view = loaded->images.views[2];
  EXPECT_EQ(view.name, "ring_02.png");
  EXPECT_EQ(loaded->images.NumLevels(), 3);
  EXPECT_FLOAT_EQ(view.gray[0](3, 5), 13.0F / 255);
  EXPECT_EQ(view.colour.size(), cv::Size(32, 24));
  EXPECT_EQ(view.colour_level, 1);
  EXPECT_TRUE(view.mask.empty());
  EXPECT_EQ(ring_.cameras[0].width_px, 64);  // filled in
  EXPECT_EQ(ring_.cameras[0].height_px, 48);
  EXPECT_EQ(view.undistorted_with.width_px, 64);
  EXPECT_THAT(loaded->object_share, Each(1.0));
  EXPECT_THAT(loaded->mask_kind, Each(MaskKind::kNone));
  ASSERT_EQ(loaded->files.size(), 4U);
  EXPECT_EQ(loaded->files[2].name, "ring_02.png");
  EXPECT_EQ(loaded->files[2].sha256, Sha256Hex(*ReadFile(folder_.Path() / "ring_02.png")));
}

TEST_F(LoadImagesTest, PicturesAndMasksAreUndistorted) {
  ring_.cameras[0].k1 = 0.05;
  const auto loaded = Load(WithMasks());
  ASSERT_TRUE(loaded) << Message(loaded);
  const ViewImages& view = loaded->images.views[0];
  // The pinhole pixel (50, 30) was taken at 2 x + y of its distorted place.
  const Camera& camera = ring_.cameras[0];
  const Eigen::Vector3d ray = *RayInCam(Undistorted(camera), {50, 30});
  const Eigen::Vector2d original = *Project(camera, ray);
  EXPECT_GT(original.x(), 50.3);
  constexpr double kRemapError =
      0.2;  // grey levels: 1/32 px steps and cv::INTER_CUBIC's 0.05 px on a ramp of 2.2 a pixel
  EXPECT_NEAR(view.gray[0](30, 50) * 255, 2 * original.x() + original.y(), kRemapError);
  EXPECT_EQ(view.mask(24, 30), 255);
  EXPECT_EQ(view.mask(24, 33), 0);
}

TEST_F(LoadImagesTest, MasksFromAFolder) {
  const auto loaded = Load(WithMasks());
  ASSERT_TRUE(loaded) << Message(loaded);
  EXPECT_TRUE(loaded->images.views[1].IsObject({31, 10}));
  EXPECT_FALSE(loaded->images.views[1].IsObject({32, 10}));
  EXPECT_THAT(loaded->object_share, Each(0.5));
  EXPECT_THAT(loaded->mask_kind, Each(MaskKind::kFile));
  EXPECT_EQ(loaded->files.size(), 8U);
}

TEST_F(LoadImagesTest, SameForOneAndTwoThreads) {
  const auto one = Load(WithMasks(), 1), two = Load(WithMasks(), 2);
  ASSERT_TRUE(one && two);
  for (int v = 0; v < 4; ++v)
    EXPECT_EQ(cv::norm(one->images.views[v].gray[0], two->images.views[v].gray[0], cv::NORM_INF), 0);
}

TEST_F(LoadImagesTest, StopsOnRequest) {
  std::stop_source stop;
  stop.request_stop();
  const auto loaded = LoadImages(folder_.Path(), ring_, {.masks = MaskSource::kNone}, {.stop = stop.get_token()});
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kCancelled);
}

TEST_F(LoadImagesTest, MissingImage) {
  std::filesystem::remove(folder_.Path() / "ring_01.png");
  const auto loaded = Load();
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(loaded.error().message, HasSubstr("ring_01.png"));
}

TEST_F(LoadImagesTest, ImageThatIsNotTheRecordedOne) {
  ImageOptions options{.masks = MaskSource::kNone};
  options.sha256_by_image["ring_01.png"] = Sha256Hex(*ReadFile(folder_.Path() / "ring_01.png"));
  EXPECT_TRUE(Load(options));
  options.sha256_by_image["ring_01.png"] = std::string(64, 'a');
  EXPECT_THAT(Message(Load(options)), AllOf(HasSubstr("ring_01.png"), HasSubstr("aaaa"), HasSubstr("was changed")));
}

TEST_F(LoadImagesTest, OverExposedObject) {
  cv::Mat picture = Picture();
  picture.colRange(0, 15) = cv::Scalar(255);  // of the 32 columns that are object
  WriteImage(folder_.Path() / "ring_01.png", picture);
  EXPECT_TRUE(Load(WithMasks()));
  picture.colRange(0, 17) = cv::Scalar(255);
  WriteImage(folder_.Path() / "ring_01.png", picture);
  EXPECT_THAT(Message(Load(WithMasks())),
              AllOf(HasSubstr("ring_01.png"), HasSubstr("53 %"), HasSubstr("over-exposed")));
  EXPECT_TRUE(Load()) << "without a mask it may be the backdrop";
}

TEST_F(LoadImagesTest, UnreadableImage) {
  folder_.Write("ring_01.png", "this is a text");
  EXPECT_THAT(Message(Load()), AllOf(HasSubstr("ring_01.png"), HasSubstr("not an image")));
}

TEST_F(LoadImagesTest, TruncatedPng) {
  const std::string whole = *ReadFile(folder_.Path() / "ring_03.png");
  folder_.Write("ring_03.png", whole.substr(0, whole.size() / 2));
  EXPECT_THAT(Message(Load()), AllOf(HasSubstr("ring_03.png"), HasSubstr("truncated")));
}

TEST_F(LoadImagesTest, ImagesOfOneCameraThatDifferInSize) {
  WriteImage(folder_.Path() / "ring_02.png", cv::Mat(40, 64, CV_8UC1, cv::Scalar(9)));
  EXPECT_THAT(Message(Load()), AllOf(HasSubstr("ring_02.png"), HasSubstr("64 x 40"), HasSubstr("64 x 48")));
  ring_.cameras[0].width_px = ring_.cameras[0].height_px = 0;
  EXPECT_THAT(Message(Load()), AllOf(HasSubstr("'ring_00.png' is 64 x 48"), HasSubstr("'ring_02.png' is 64 x 40")));
}

TEST_F(LoadImagesTest, PrincipalPointOutsideTheImage) {
  ring_.cameras[0].cx_px = 64;
  EXPECT_THAT(Message(Load()), AllOf(HasSubstr("ring_00.png"), HasSubstr("(64, "), HasSubstr("64 x 48")));
}

TEST_F(LoadImagesTest, CamerasThatLookAway) {
  for (View& view : ring_.views)
    view.cam_from_world = Rigid3d{Eigen::Quaterniond(0, 0, 1, 0), Eigen::Vector3d::Zero()} * view.cam_from_world;
  EXPECT_THAT(Message(Load()), HasSubstr("look away"));
}

TEST_F(LoadImagesTest, MaskOfTheWrongSize) {
  WriteImage(Mask("ring_01.png"), cv::Mat(24, 32, CV_8UC1, cv::Scalar(255)));
  EXPECT_THAT(Message(Load(WithMasks())), AllOf(HasSubstr("masks/ring_01.png"), HasSubstr("32 x 24")));
}

TEST_F(LoadImagesTest, NoMaskForAnImage) {
  std::filesystem::remove(Mask("ring_01.png"));
  EXPECT_THAT(Message(Load(WithMasks())), HasSubstr("'ring_01.png'"));
}

}  // namespace
}  // namespace rigcal
