#include "core/seed/start_cameras.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <set>

namespace rigcal {
namespace {

/// Starting values need no more: OpenCV's time grows with them.
constexpr int kMaxStartViews = 20;
/// A corner this far from the homography of its view's others has a wrong id or place; less may be distortion.
constexpr double kGrossShareOfWidth = 0.02;

struct FlatView {
  std::vector<cv::Point3f> x_in_board;
  std::vector<cv::Point2f> x_px;
};

/// The corners that agree with each other, for starting values only.
FlatView AgreeingCorners(const Board& board, const ChartView& view, int width_px) {
  FlatView all, kept;
  std::vector<cv::Point2f> plane;
  for (const ChartCorner& corner : view.corners) {
    const Eigen::Vector3d x = TagCornerInBoard(board, corner.tag_id, corner.corner);
    all.x_in_board.emplace_back(static_cast<float>(x.x()), static_cast<float>(x.y()), 0.0F);
    plane.emplace_back(static_cast<float>(x.x()), static_cast<float>(x.y()));
    all.x_px.emplace_back(static_cast<float>(corner.x_px.x()), static_cast<float>(corner.x_px.y()));
  }
  std::vector<unsigned char> inlier;
  cv::findHomography(plane, all.x_px, cv::RANSAC, kGrossShareOfWidth * width_px, inlier);
  for (std::size_t i = 0; i < inlier.size(); ++i) {
    if (inlier[i] == 0) continue;
    kept.x_in_board.push_back(all.x_in_board[i]);
    kept.x_px.push_back(all.x_px[i]);
  }
  return kept;
}

cv::Mat MatrixOf(const Camera& camera) {
  return (cv::Mat_<double>(3, 3) << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
}

Camera StartCamera(const SeedCamera& known, const std::vector<FlatView>& views) {
  std::vector<std::vector<cv::Point3f>> x_in_board;
  std::vector<std::vector<cv::Point2f>> x_px;
  const double stride = std::max(1.0, static_cast<double>(views.size()) / kMaxStartViews);
  for (double i = 0; i < static_cast<double>(views.size()); i += stride) {
    x_in_board.push_back(views[static_cast<std::size_t>(i)].x_in_board);
    x_px.push_back(views[static_cast<std::size_t>(i)].x_px);
  }
  cv::Mat k, distortion;
  std::vector<cv::Mat> rotations, translations;
  cv::calibrateCamera(x_in_board, x_px, {known.width_px, known.height_px}, k, distortion, rotations, translations,
                      cv::CALIB_FIX_K3);
  Camera camera;
  camera.id = camera.physical_id = known.id;
  camera.width_px = known.width_px, camera.height_px = known.height_px;
  camera.fx_px = k.at<double>(0, 0), camera.fy_px = k.at<double>(1, 1);
  camera.cx_px = k.at<double>(0, 2), camera.cy_px = k.at<double>(1, 2);
  const auto* d = distortion.ptr<double>();
  camera.k1 = d[0], camera.k2 = d[1], camera.p1 = d[2], camera.p2 = d[3];
  return camera;
}

Rigid3d PoseFrom(const cv::Mat& rotation, const cv::Mat& translation) {
  Eigen::Vector3d w, t;
  cv::cv2eigen(rotation, w);
  cv::cv2eigen(translation, t);
  return {ExpRotation(w), t};
}

/// The better of the two poses that a flat board allows.
std::optional<Rigid3d> StartPose(const Camera& camera, const FlatView& view) {
  const cv::Mat k = MatrixOf(camera);
  const cv::Mat distortion = (cv::Mat_<double>(1, 4) << camera.k1, camera.k2, camera.p1, camera.p2);
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(view.x_in_board, view.x_px, k, distortion, rotations, translations, false, cv::SOLVEPNP_IPPE);
  std::optional<Rigid3d> best;
  double best_error2 = 0;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    cv::solvePnPRefineLM(view.x_in_board, view.x_px, k, distortion, rotations[i], translations[i]);
    const Rigid3d pose = PoseFrom(rotations[i], translations[i]);
    double error2 = 0;
    for (std::size_t n = 0; n < view.x_px.size(); ++n) {
      const cv::Point3f& x = view.x_in_board[n];
      const auto seen = Project(camera, pose * Eigen::Vector3d(x.x, x.y, x.z));
      error2 += seen ? (*seen - Eigen::Vector2d(view.x_px[n].x, view.x_px[n].y)).squaredNorm() : HUGE_VAL;
    }
    if (std::isfinite(error2) && (!best || error2 < best_error2)) best = pose, best_error2 = error2;
  }
  return best;
}

}  // namespace

Result<ChartState> StartCameras(const SeedScene& scene, const SeedOptions& options, const Execution& execution,
                                std::vector<ChartView>& views) {
  ChartState state;
  state.cam_from_board.resize(views.size());
  for (int c = 0; c < static_cast<int>(scene.cameras.size()); ++c) {
    const SeedCamera& known = scene.cameras[c];
    std::vector<FlatView> flat;
    std::vector<int> view_of;
    for (int v = 0; v < static_cast<int>(views.size()); ++v) {
      if (execution.Stopped()) return Cancelled("seeding");
      if (views[v].camera != c || views[v].corners.empty()) continue;
      FlatView agreeing = AgreeingCorners(scene.board, views[v], known.width_px);
      if (static_cast<int>(agreeing.x_px.size()) < options.min_corners_per_view) {
        views[v].corners.clear();
        continue;
      }
      flat.push_back(std::move(agreeing));
      view_of.push_back(v);
    }
    const auto too_few = [&](std::size_t num_views) {
      return Fail(ErrorCode::kBadInput,
                  "camera {}: {} views show at least {} corners of the chart that agree, {} are needed", known.id,
                  num_views, options.min_corners_per_view, options.min_views_per_camera);
    };
    const auto least = static_cast<std::size_t>(options.min_views_per_camera);
    if (flat.size() < least) return too_few(flat.size());
    std::size_t num_posed = 0;
    try {
      state.cameras.push_back(StartCamera(known, flat));
      for (std::size_t i = 0; i < flat.size(); ++i) {
        if (execution.Stopped()) return Cancelled("seeding");
        const std::optional<Rigid3d> pose = StartPose(state.cameras.back(), flat[i]);
        if (pose) state.cam_from_board[view_of[i]] = *pose, ++num_posed;
        if (!pose) views[view_of[i]].corners.clear();
      }
    } catch (const cv::Exception& exception) {
      return Fail(ErrorCode::kBadInput, "camera {}: its {} views of the chart do not determine a lens ({})", known.id,
                  flat.size(), exception.err);
    }
    if (num_posed < least) return too_few(num_posed);
  }
  return state;
}

}  // namespace rigcal
