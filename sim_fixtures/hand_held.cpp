#include "sim_fixtures/hand_held.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/ensure.h"
#include "core/base/random.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::uint64_t kHandTask = 20000;               ///< DeriveSeed: + camera
constexpr double kLeastFilled = 0.3, kMostFilled = 0.9;  ///< of the picture's height
constexpr double kMostTilt_rad = std::numbers::pi / 4;
/// From the picture's rim to the board's corner that is held there, in shares of the picture: a person's aim.
constexpr double kLeastInset = 0.01, kMostInset = 0.06;
constexpr double kMiddleShare = 0.25;  ///< how far from the middle a board about the middle may be, in shares
constexpr int kPlaces = 5;             ///< the picture's corners and its middle

/// The outer corners of the tags.
std::array<Vector3d, 4> Outline(const Board& board) {
  const Vector3d far = 2 * CentreInBoard(board);
  return {Vector3d(0, 0, 0), Vector3d(far.x(), 0, 0), Vector3d(far.x(), far.y(), 0), Vector3d(0, far.y(), 0)};
}

/// Which point of the board is held on which line of sight.
struct Hold {
  Vector3d x_in_board, ray_in_cam;
  Eigen::Quaterniond cam_from_board;

  [[nodiscard]] Rigid3d At(double depth_m) const {
    return {cam_from_board, depth_m * ray_in_cam - cam_from_board * x_in_board};
  }
};

Vector3d RayAt(const Camera& camera, const Vector2d& share) {
  const auto ray = RayInCam(camera, {share.x() * (camera.width_px - 1), share.y() * (camera.height_px - 1)});
  Ensure(ray.has_value(), "the distortion can be inverted all over the picture");
  return *ray;
}

Hold DrawHold(const Board& board, const Camera& camera, int place, Random& random) {
  const double tilt_rad = kMostTilt_rad * random.Uniform(), towards_rad = 2 * std::numbers::pi * random.Uniform();
  const double turn_rad = 2 * std::numbers::pi * random.Uniform();
  const Vector2d draw(random.Uniform(), random.Uniform());
  const bool in_corner = place < kPlaces - 1;
  const Vector2d side(place % 2 == 0 ? -1 : 1, place / 2 == 0 ? -1 : 1);  // left or right, upper or lower corner
  const Vector2d inset = Vector2d::Constant(kLeastInset) + (kMostInset - kLeastInset) * draw;
  const Vector2d from_middle = in_corner ? Vector2d(side.cwiseProduct(Vector2d::Constant(0.5) - inset))
                                         : Vector2d(2 * kMiddleShare * (draw - Vector2d::Constant(0.5)));
  Hold hold;
  hold.ray_in_cam = RayAt(camera, Vector2d::Constant(0.5) + from_middle);
  const Eigen::Quaterniond facing = ExpRotation({std::numbers::pi, 0, 0});  // the board's +z towards the camera
  hold.cam_from_board = (Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), hold.ray_in_cam) *
                         ExpRotation({tilt_rad * std::cos(towards_rad), tilt_rad * std::sin(towards_rad), 0}) *
                         ExpRotation({0, 0, turn_rad}) * facing)
                            .normalized();
  hold.x_in_board = CentreInBoard(board);
  if (!in_corner) return hold;
  const auto outwards = [&](const Vector3d& x) { return (hold.cam_from_board * x).head<2>().dot(side); };
  const std::array<Vector3d, 4> outline = Outline(board);
  hold.x_in_board = *std::max_element(outline.begin(), outline.end(),
                                      [&](const Vector3d& a, const Vector3d& b) { return outwards(a) < outwards(b); });
  return hold;
}

/// The depth at which the tags fill `filled` of the picture's height, by bisection.
Rigid3d AtFill(const Hold& hold, const Board& board, const Camera& camera, double filled) {
  const std::array<Vector3d, 4> outline = Outline(board);
  const double across_m = outline[2].norm();
  const auto filled_at = [&](double depth_m) {
    double low = INFINITY, high = -INFINITY;
    for (const Vector3d& x : outline) {
      const Vector3d x_in_cam = hold.At(depth_m) * x;
      const double y_px = camera.fy_px * x_in_cam.y() / x_in_cam.z();
      low = std::min(low, y_px), high = std::max(high, y_px);
    }
    return (high - low) / camera.height_px;
  };
  double near_m = 1.5 * across_m, far_m = 100 * across_m;  // nearer, a tilted board would reach the camera
  for (int i = 0; i < 50; ++i) {
    const double middle_m = 0.5 * (near_m + far_m);
    (filled_at(middle_m) > filled ? near_m : far_m) = middle_m;
  }
  return hold.At(far_m);
}

}  // namespace

std::vector<HandHeldView> HoldByHand(const ChartOptions& options, const std::vector<Camera>& cameras,
                                     std::uint64_t random_seed) {
  const int digits = options.num_hand_held > 100 ? 3 : 2;
  std::vector<HandHeldView> views;
  for (int c = 0; c < static_cast<int>(cameras.size()); ++c) {
    Random random(DeriveSeed(random_seed, kHandTask + static_cast<std::uint64_t>(c)));
    for (int i = 0; i < options.num_hand_held; ++i) {
      const Hold hold = DrawHold(options.print.board, cameras[c], i % kPlaces, random);
      const double filled = random.Uniform(kLeastFilled, kMostFilled);
      views.push_back({fmt::format("{}_hand{:0{}}.png", cameras[c].id, i, digits), c,
                       AtFill(hold, options.print.board, cameras[c], filled)});
    }
  }
  return views;
}

}  // namespace rigcal::sim
