#include "core/mvs/stereo_scene.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/ensure.h"

namespace rigcal::stereo {
namespace {

/// From this error on (pixels of the level) offsets are free. Below it a window of 7 pixels loses less than 0.02 of its
/// NCC and a joint fit is more precise than one with offsets (measured on templeSparseRing at level 2).
constexpr double kFreeOffsetsFromErrorPx = 0.3;

/// Coverage (of 255) from which a pixel of the level is taken to show the object alone.
constexpr int kPureObject = 250;

/// 1 where a pixel of the level shows nothing but the object, 0 elsewhere.
cv::Mat1f ObjectPixels(const ViewImages& pictures, int level) {
  const cv::Size size = pictures.gray[level].size();
  if (pictures.mask.empty()) return cv::Mat1f(size, 1.0f);
  cv::Mat coverage = pictures.mask >= kMaskThreshold;  // 255 or 0
  for (int l = 0; l < level; ++l) cv::pyrDown(coverage, coverage);
  // MakeTexels() smooths over the next pixel.
  cv::erode(coverage, coverage, cv::Mat::ones(3, 3, CV_8U), {-1, -1}, 1, cv::BORDER_REPLICATE);
  cv::Mat1f on_object;
  cv::Mat(coverage >= kPureObject).convertTo(on_object, CV_32F, 1.0 / 255);
  return on_object;
}

/// The picture is smoothed a little first ([1 4 1] / 6 in both directions, the cubic B-spline): bilinear samples blur
/// by where they fall between the pixels, and what is blurred already feels that less.
cv::Mat4f MakeTexels(const cv::Mat1f& image, const cv::Mat1f& on_object) {
  const cv::Mat1f smooth_kernel = (cv::Mat1f(1, 3) << 1 / 6.f, 4 / 6.f, 1 / 6.f);
  const cv::Mat1f difference_kernel = (cv::Mat1f(1, 5) << 1 / 12.f, -8 / 12.f, 0, 8 / 12.f, -1 / 12.f);  // fourth order
  const cv::Mat1f one(1, 1, 1.0f);
  std::array<cv::Mat1f, 4> channels;
  cv::sepFilter2D(image, channels[0], CV_32F, smooth_kernel, smooth_kernel);
  cv::sepFilter2D(channels[0], channels[1], CV_32F, difference_kernel, one);
  cv::sepFilter2D(channels[0], channels[2], CV_32F, one, difference_kernel);
  channels[3] = on_object;
  cv::Mat4f texels;
  cv::merge(channels.data(), channels.size(), texels);
  return texels;
}

StereoView MakeView(const ViewImages& pictures, const Camera& camera, const Rigid3d& cam_from_world,
                    const StereoOptions& options, std::size_t index) {
  const double scale = std::ldexp(1.0, -options.level);
  StereoView view;
  view.texels = MakeTexels(pictures.gray[options.level], ObjectPixels(pictures, options.level));
  cv::extractChannel(view.texels, view.gray, 0);
  view.full_size = &pictures;
  view.px_from_world = ProjectionMatrix(camera, cam_from_world, options.level);
  view.direction_from_px = view.px_from_world.leftCols<3>().inverse();
  view.centre_in_world = CentreInWorld(cam_from_world);
  view.focal_px = 0.5 * (camera.fx_px + camera.fy_px) * scale;
  view.error_px = options.expected_error_px.empty() ? 0 : options.expected_error_px[index] * scale;
  return view;
}

}  // namespace

std::optional<Pixel> StereoScene::Project(int view, const Eigen::Vector3d& x_in_world) const {
  const Eigen::Vector3d q = views[view].px_from_world * x_in_world.homogeneous();
  if (!(q.z() > 0)) return std::nullopt;
  return Pixel{q.head<2>() / q.z(), q.z()};
}

Eigen::Vector3d StereoScene::TowardsCamera(int view, const Eigen::Vector3d& x_in_world) const {
  return (views[view].centre_in_world - x_in_world).normalized();
}

bool StereoScene::CanHoldWindow(int view, const Eigen::Vector2d& x_px) const {
  const double border = options.window_px / 2;
  const cv::Mat4f& image = views[view].texels;
  if (!(x_px.x() >= border && x_px.y() >= border && x_px.x() <= image.cols - 1 - border &&
        x_px.y() <= image.rows - 1 - border)) {
    return false;
  }
  return views[view].full_size->IsObject(x_px * std::ldexp(1.0, options.level));
}

std::optional<StereoScene> MakeStereoScene(const ImageSet& images, const RigCalibration& calibration,
                                           const StereoOptions& options, const Execution& execution) {
  Ensure(images.NumViews() == calibration.NumViews(), "images and calibration have different views");
  Ensure(options.level >= 0 && options.level < images.NumLevels(), "the pyramids do not reach the level of the stereo");
  Ensure(options.window_px >= 3 && options.window_px <= kMaxStereoWindowPx && options.window_px % 2 == 1,
         "the correlation window has an odd side between 3 and kMaxStereoWindowPx");
  Ensure(options.cell_px >= 1 && options.min_views >= 2, "a cell has a pixel, a patch has two views");
  Ensure(options.expected_error_px.empty() || static_cast<int>(options.expected_error_px.size()) == images.NumViews(),
         "expected_error_px has one entry per view or none");
  StereoScene scene;
  scene.options = options;
  scene.views.resize(images.views.size());
  const bool finished = ParallelFor(execution, images.NumViews(), [&](int i) {
    scene.views[i] = MakeView(images.views[i], calibration.CameraOf(i), calibration.views[i].cam_from_world, options,
                              static_cast<std::size_t>(i));
  });
  if (!finished) return std::nullopt;
  for (const StereoView& r : scene.views) {
    scene.free_offsets = scene.free_offsets || r.error_px >= kFreeOffsetsFromErrorPx;
    for (const StereoView& j : scene.views) {
      scene.pairs.push_back(
          {j.px_from_world.leftCols<3>() * r.direction_from_px, j.px_from_world * r.centre_in_world.homogeneous()});
    }
  }
  return scene;
}

}  // namespace rigcal::stereo
