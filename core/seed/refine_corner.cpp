#include "core/seed/refine_corner.h"

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/seed/gamma.h"

namespace rigcal {
namespace {

// The two edges meet at (kX, kY) relative to the middle of the window, at angles kAngle0 and kAngle1 to the x axis.
// kSlopeX and kSlopeY: relative change of brightness over one pixel.
enum ShapeIndex { kX, kY, kAngle0, kAngle1, kLogBlur, kInside, kOutside, kSlopeX, kSlopeY, kNumShape };
using Shape = Eigen::Matrix<double, kNumShape, 1>;

// Without noise a fit's residual is about that of 8-bit rounding; it never counts as less.
constexpr double kMinNoise = 0.3 / 255;
// Brightness changes by less than this share a pixel, except where a shadow falls: keeps the slope from standing in for
// an edge in windows of a few pixels.
constexpr double kSlopeSigma = 0.02;
// A printed edge in a lens's picture is blurred by no less than the pixel's own width (1/sqrt(12) px), mostly by half a
// pixel. First guess and weak prior of its logarithm.
constexpr double kTypicalBlurPx = 0.6;
constexpr double kLogBlurSigma = 1.0;
constexpr int kNumPriors = 3;
constexpr double kPriorNoise = 0.02;  // noise of grey values against which the priors are weighed

constexpr double kFirstReachPx = 6;  // of the window across the edges, before the blur is known
constexpr double kReachInBlurs = 4;  // of the window across the edges, once it is known
constexpr double kMinReachPx = 2.5;
constexpr double kMaxAlongPx = 20;         // edges bend by lens distortion; over 20 px by less than 0.01 px (k1 = -0.2)
constexpr double kKeepOffBlurs = 1.6;      // from the next edge: there 95 % of the step are over
constexpr double kMinKeepOffShare = 0.45;  // of the plain distance that stays in use however large the blur is

constexpr double kNearCornerPx = 3;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

struct Window {
  struct Pixel {
    double x, y, value;  // place relative to the middle; value as recorded
  };
  std::vector<Pixel> pixels;
  Eigen::Vector2d middle_px;
  bool linear;
};

// A wedge between two edges, blurred by a Gaussian, is a bivariate normal distribution function of the distances a and
// b from its edges (in blurs): the product of both edges' own steps where they are perpendicular, else plus this, the
// first terms of the tetrachoric series in the cosine between the edges' normals.
template <typename T>
T WedgeTerm(const T& a, const T& b, const T& rho) {
  using std::exp;
  constexpr double kCutSquared = 25;  // nothing is left five blurs away
  const T squared = a * a + b * b;
  if (squared > kCutSquared) return T(0);
  const T density = exp(squared * -0.5) * (0.5 / std::numbers::pi);
  return density * rho * (1.0 + rho * (0.5 * a * b + rho * (1 / 6.0) * (a * a - 1.0) * (b * b - 1.0)));
}

// Residuals: model minus pixel, then the priors.
struct EdgeFit {
  const std::vector<Window::Pixel>& pixels;
  double side;  // +1 when edge 1 lies to the left of edge 0 (angles increasing), else -1
  bool is_crossing;
  bool linear;

  [[nodiscard]] int NumResiduals() const { return static_cast<int>(pixels.size()) + kNumPriors; }

  template <typename T>
  bool operator()(const T* shape, T* residuals) const {
    using std::cos, std::sin, std::exp, std::erf;
    const T cos0 = cos(shape[kAngle0]) * side, sin0 = sin(shape[kAngle0]) * side;
    const T cos1 = cos(shape[kAngle1]) * side, sin1 = sin(shape[kAngle1]) * side;
    const T scale = exp(-shape[kLogBlur]);
    const T rho = -(cos0 * cos1 + sin0 * sin1);  // cosine between the edges' inward normals
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const T dx = pixels[i].x - shape[kX], dy = pixels[i].y - shape[kY];
      const T a = (cos0 * dy - sin0 * dx) * scale, b = (sin1 * dx - cos1 * dy) * scale;
      const T in0 = 0.5 + 0.5 * erf(a * (1 / std::numbers::sqrt2)),
              in1 = 0.5 + 0.5 * erf(b * (1 / std::numbers::sqrt2));
      T inside = in0 * in1 + WedgeTerm(a, b, rho);
      if (is_crossing) inside = 1.0 - in0 - in1 + 2.0 * inside;
      const T slope = 1.0 + shape[kSlopeX] * pixels[i].x + shape[kSlopeY] * pixels[i].y;
      const T light = slope * (shape[kOutside] + (shape[kInside] - shape[kOutside]) * inside);
      residuals[i] = (linear ? light : SrgbEncoded(light)) - pixels[i].value;
    }
    T* priors = residuals + pixels.size();
    priors[0] = shape[kSlopeX] * (kPriorNoise / kSlopeSigma);
    priors[1] = shape[kSlopeY] * (kPriorNoise / kSlopeSigma);
    priors[2] = (shape[kLogBlur] - std::log(kTypicalBlurPx)) * (kPriorNoise / kLogBlurSigma);
    return true;
  }
};

// Across the edge up to where the next structure begins to show.
double Reach(double plain_px, double blur_px, double reach_px) {
  return std::min(reach_px, std::max(plain_px - kKeepOffBlurs * blur_px, plain_px * kMinKeepOffShare));
}

// Pixels around the corner that see nothing but its two edges. Empty when the window leaves the picture.
Window CutWindow(const RecordedPicture& picture, const CornerPlace& place, double blur_px, double reach_px) {
  Window window{{}, {std::round(place.x_px.x()), std::round(place.x_px.y())}, picture.linear};
  const double side = Cross(place.along[0], place.along[1]) > 0 ? 1 : -1;
  std::array<double, 2> inside, outside, along;
  for (int e = 0; e < 2; ++e) {
    inside[e] = Reach(place.inside_px[e], blur_px, reach_px);
    outside[e] = Reach(place.outside_px[e], blur_px, reach_px);
    if (place.is_crossing) inside[e] = outside[e] = std::min(inside[e], outside[e]);
    along[e] = std::min(kMaxAlongPx, place.length_px[e] / 2);
  }
  const double sine = std::abs(Cross(place.along[0], place.along[1]));
  const int half =
      static_cast<int>(std::ceil(std::max({along[0], along[1], inside[0], inside[1], outside[0], outside[1]}) /
                                 std::max(sine, 0.2))) +
      1;
  for (int row = -half; row <= half; ++row) {
    for (int column = -half; column <= half; ++column) {
      const Eigen::Vector2d from_corner = window.middle_px + Eigen::Vector2d(column, row) - place.x_px;
      const double across0 = side * Cross(place.along[0], from_corner),
                   across1 = -side * Cross(place.along[1], from_corner);
      const double along0 = across1 / sine, along1 = across0 / sine;  // oblique coordinates
      if (across0 < -outside[0] || across1 < -outside[1] || along0 > along[0] || along1 > along[1]) continue;
      if (across0 > inside[0] && across1 > inside[1]) continue;
      if (place.is_crossing && (across0 > inside[0] || across1 > inside[1])) continue;
      const int x = static_cast<int>(window.middle_px.x()) + column, y = static_cast<int>(window.middle_px.y()) + row;
      if (x < 0 || y < 0 || x >= picture.values.cols || y >= picture.values.rows)
        return {{}, window.middle_px, picture.linear};
      window.pixels.push_back({static_cast<double>(column), static_cast<double>(row), picture.values(y, x)});
    }
  }
  return window;
}

Shape FirstGuess(const Window& window, const CornerPlace& place) {
  Shape shape = Shape::Zero();
  shape.head<2>() = place.x_px - window.middle_px;
  for (int e = 0; e < 2; ++e) shape[kAngle0 + e] = std::atan2(place.along[e].y(), place.along[e].x());
  shape[kLogBlur] = std::log(kTypicalBlurPx);
  // Brightness by the side on which the pixels lie.
  const double side = Cross(place.along[0], place.along[1]) > 0 ? 1 : -1;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero(), count = Eigen::Vector2d::Constant(1e-9);
  for (const Window::Pixel& pixel : window.pixels) {
    const Eigen::Vector2d from_corner = window.middle_px + Eigen::Vector2d(pixel.x, pixel.y) - place.x_px;
    const bool in0 = side * Cross(place.along[0], from_corner) > 0,
               in1 = -side * Cross(place.along[1], from_corner) > 0;
    const int outside = place.is_crossing ? in0 != in1 : !(in0 && in1);
    sum[outside] += window.linear ? pixel.value : SrgbDecoded(pixel.value), count[outside] += 1;
  }
  shape[kInside] = sum[0] / count[0], shape[kOutside] = sum[1] / count[1];
  return shape;
}

struct Fit {
  Shape shape;
  Eigen::Matrix2d covariance_px2;
  double residual_rms;  // of the window, or of the corner's own surroundings where that is more
};

// Long edges can outvote what hides the corner itself.
double RmsNearCorner(const Window& window, const Shape& shape, const Eigen::VectorXd& residuals) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < window.pixels.size(); ++i) {
    if (std::hypot(window.pixels[i].x - shape[kX], window.pixels[i].y - shape[kY]) > kNearCornerPx) continue;
    sum += residuals[static_cast<Eigen::Index>(i)] * residuals[static_cast<Eigen::Index>(i)];
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

std::optional<Fit> FitEdges(const Window& window, const CornerPlace& place, Shape shape) {
  constexpr int kMinSpare = 8;  // pixels more than parameters
  if (static_cast<int>(window.pixels.size()) < kNumShape + kMinSpare) return std::nullopt;
  const double side = Cross(place.along[0], place.along[1]) > 0 ? 1 : -1;
  const EdgeFit edges{window.pixels, side, place.is_crossing, window.linear};
  using Function = ceres::TinySolverAutoDiffFunction<EdgeFit, Eigen::Dynamic, kNumShape>;
  const Function function(edges);
  ceres::TinySolver<Function> solver;
  solver.options.function_tolerance = 1e-12;
  solver.options.cost_threshold = 1e-14;
  solver.Solve(function, &shape);
  if (!shape.allFinite()) return std::nullopt;
  const int rows = edges.NumResiduals();
  Eigen::VectorXd residuals(rows);
  Eigen::Matrix<double, Eigen::Dynamic, kNumShape> jacobian(rows, kNumShape);
  function(shape.data(), residuals.data(), jacobian.data());
  const Eigen::Index num_pixels = rows - kNumPriors;
  const double variance = std::max(
      residuals.head(num_pixels).squaredNorm() / static_cast<double>(num_pixels - kNumShape), kMinNoise * kMinNoise);
  const Eigen::Matrix<double, kNumShape, kNumShape> information = jacobian.transpose() * jacobian;
  const auto solved = information.ldlt();
  if (solved.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix<double, kNumShape, kNumShape> inverse = solved.solve(information.Identity(kNumShape, kNumShape));
  return Fit{shape,
             variance * inverse.topLeftCorner<2, 2>() + kModelSigmaPx * kModelSigmaPx * Eigen::Matrix2d::Identity(),
             std::max(std::sqrt(variance), RmsNearCorner(window, shape, residuals))};
}

bool IsNear(const CornerLimits& limits, const CornerPlace& place, const Eigen::Vector2d& x_px) {
  const double plain_px = std::min(place.inside_px[0], place.inside_px[1]);
  return (x_px - place.x_px).norm() <= std::max(limits.min_shift_px, limits.max_shift_share * plain_px);
}

bool Meets(const CornerLimits& limits, const CornerPlace& place, const RefinedCorner& corner) {
  const double plain_px = std::min(place.inside_px[0], place.inside_px[1]);
  const double worst = corner.covariance_px2.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  return corner.x_px.allFinite() && corner.contrast >= limits.min_contrast && corner.residual <= limits.max_residual &&
         corner.blur_px <= limits.max_blur_share * plain_px && worst <= limits.max_sigma_px * limits.max_sigma_px &&
         IsNear(limits, place, corner.x_px);
}

}  // namespace

std::optional<RefinedCorner> RefineCorner(const RecordedPicture& picture, const CornerPlace& place,
                                          const CornerLimits& limits) {
  const Window first = CutWindow(picture, place, kTypicalBlurPx, kFirstReachPx);
  const std::optional<Fit> rough = FitEdges(first, place, FirstGuess(first, place));
  if (!rough) return std::nullopt;
  // Once more, with a window at the right place that suits the blur.
  CornerPlace better = place;
  better.x_px = first.middle_px + rough->shape.head<2>();
  if (!IsNear(limits, place, better.x_px)) return std::nullopt;
  for (int e = 0; e < 2; ++e)
    better.along[e] = {std::cos(rough->shape[kAngle0 + e]), std::sin(rough->shape[kAngle0 + e])};
  const double blur_px = std::exp(rough->shape[kLogBlur]);
  const Window second = CutWindow(picture, better, blur_px, std::max(kMinReachPx, kReachInBlurs * blur_px));
  Shape start = rough->shape;
  start.head<2>() += first.middle_px - second.middle_px;
  const std::optional<Fit> fit = FitEdges(second, better, start);
  if (!fit) return std::nullopt;
  const auto recorded = [&](double light) { return picture.linear ? light : SrgbEncoded(light); };
  const double contrast = std::abs(recorded(fit->shape[kOutside]) - recorded(fit->shape[kInside]));
  RefinedCorner corner{second.middle_px + fit->shape.head<2>(), fit->covariance_px2, std::exp(fit->shape[kLogBlur]),
                       contrast, 0};
  corner.residual = corner.contrast > 0 ? fit->residual_rms / corner.contrast : 1;
  if (!Meets(limits, place, corner)) return std::nullopt;
  return corner;
}

}  // namespace rigcal
