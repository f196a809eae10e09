#include "core/match/match.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/base/ensure.h"
#include "core/image/undistort.h"
#include "core/match/patch_frame.h"
#include "core/match/subsample.h"
#include "core/match/window_fit.h"

namespace rigcal {
namespace {

/// Patches per call of ParallelFor: some milliseconds of work.
constexpr int kChunk = 64;
/// Gauss-Newton finds its way over this distance; a start that may be farther off is searched for.
constexpr double kConvergenceRadiusPx = 1.0;

/// A feature p_j (j != j0) on its way down the pyramid.
struct MovingFeature {
  int view;
  Eigen::Vector2d start_px;  ///< full size
  Eigen::Vector2d x_px;      ///< full size
  float ncc = 0;
  Eigen::Matrix2d fit_covariance_px2 = Eigen::Matrix2d::Identity();
  bool alive = true;
};

/// Everything of one run that all patches share.
struct MatchContext {
  const ImageSet& images;
  const std::vector<ViewGeometry>& views;
  const MatchOptions& options;
};

/// One feature at one level; false when it is lost.
bool MoveAtLevel(const MatchContext& context, const PatchFrame& frame, const ReferenceTexture& reference, int level,
                 MovingFeature& feature) {
  const cv::Mat1f& image = context.images.views[feature.view].gray[level];
  const double scale = std::ldexp(1.0, level);
  WindowShape shape;
  if (!ShapeInView(frame, context.views[feature.view], level, context.options.window_px, shape)) return false;
  const auto sought = MakeTemplate(reference, shape);
  if (!sought) return false;
  const double radius_px = context.options.expected_error_px[feature.view] / scale;
  const Eigen::Vector2d from_px = feature.x_px / scale;
  const bool far = level == context.options.level && radius_px > kConvergenceRadiusPx;
  const auto fit = far ? SearchWindow(image, *sought, from_px, radius_px)
                       : FitWindow(image, *sought, from_px, std::max(radius_px, kConvergenceRadiusPx));
  if (!fit) return false;
  feature.x_px = scale * fit->centre_px;
  feature.ncc = fit->ncc;
  if (level == 0) feature.fit_covariance_px2 = FitCovariance(*sought, *fit);
  return true;
}

/// The last word on a feature that came down to level 0 (paper section 3.2, DESIGN.md section 3, point 4).
bool Passes(const MatchContext& context, const MovingFeature& feature) {
  return (feature.x_px - feature.start_px).norm() <= context.options.expected_error_px[feature.view] &&
         feature.ncc >= context.options.min_ncc && context.images.views[feature.view].IsObject(feature.x_px);
}

Eigen::Matrix2d Floored(const Eigen::Matrix2d& covariance_px2, double floor_px) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance_px2);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(floor_px * floor_px).asDiagonal() *
         eigen.eigenvectors().transpose();
}

Observation MakeObservation(const MatchContext& context, int view, const Eigen::Vector2d& x_px,
                            const Eigen::Matrix2d& covariance_px2, float ncc) {
  return {view, OriginalFromUndistorted(context.images.views[view].undistorted_with, x_px),
          Floored(covariance_px2, context.options.min_sigma_px), ncc};
}

Eigen::Matrix2d PxFromStep(const MatchContext& context, const PatchFrame& frame, int view) {
  WindowShape shape;
  ShapeInView(frame, context.views[view], 0, 1, shape);
  return shape.px_from_step;
}

/// The track of a patch whose features have arrived. A fit's covariance is that of p_j relative to p_j0; one half goes
/// to p_j, and the mean of the other halves, brought over by the patch's shape, to p_j0, which all fits share.
std::optional<Track> MakeTrack(const MatchContext& context, const PatchFrame& frame,
                               const Eigen::Vector2d& reference_px, const std::vector<MovingFeature>& features) {
  Track track;
  track.x_in_world = frame.centre_in_world;
  track.observations.push_back({});
  Eigen::Matrix2d of_reference = Eigen::Matrix2d::Zero();
  const Eigen::Matrix2d reference_from_step = PxFromStep(context, frame, frame.reference_view);
  for (const MovingFeature& feature : features) {
    if (!feature.alive) continue;
    const Eigen::Matrix2d half = feature.fit_covariance_px2 / 2;
    const Eigen::Matrix2d to_reference = reference_from_step * PxFromStep(context, frame, feature.view).inverse();
    of_reference += to_reference * half * to_reference.transpose();
    track.observations.push_back(MakeObservation(context, feature.view, feature.x_px, half, feature.ncc));
  }
  const auto num_fits = static_cast<double>(track.observations.size() - 1);
  if (num_fits < 1) return std::nullopt;
  track.observations[0] = MakeObservation(context, frame.reference_view, reference_px, of_reference / num_fits, 1.0f);
  return track;
}

std::optional<Track> MatchPatch(const MatchContext& context, const Patch& patch) {
  const auto frame = FrameOf(patch, context.views, context.images);
  if (!frame) return std::nullopt;
  std::vector<MovingFeature> features;
  for (const int view : patch.visible_views) {
    if (view == frame->reference_view) continue;
    const auto x_px = ProjectIntoView(context.views[view], patch.centre_in_world);
    if (x_px) features.push_back({view, *x_px, *x_px});
  }
  const ViewGeometry& reference_view = context.views[frame->reference_view];
  const Pyramid& reference_images = context.images.views[frame->reference_view].gray;
  const Eigen::Vector2d reference_px = *ProjectIntoView(reference_view, patch.centre_in_world);
  for (int level = context.options.level; level >= 0; --level) {
    WindowShape shape;
    if (!ShapeInView(*frame, reference_view, level, context.options.window_px + 2 * kTextureMargin, shape)) {
      return std::nullopt;
    }
    const auto reference = SampleReference(reference_images[level], shape, reference_px / std::ldexp(1.0, level));
    if (!reference) return std::nullopt;
    for (MovingFeature& feature : features) {
      feature.alive = feature.alive && MoveAtLevel(context, *frame, *reference, level, feature);
    }
  }
  for (MovingFeature& feature : features) feature.alive = feature.alive && Passes(context, feature);
  return MakeTrack(context, *frame, reference_px, features);
}

void CheckArguments(const ImageSet& images, const RigCalibration& calibration, const MatchOptions& options) {
  Ensure(images.NumViews() == calibration.NumViews(), "matching needs one picture per view");
  Ensure(options.expected_error_px.size() == images.views.size(), "matching needs an expected error per view");
  Ensure(options.level >= 0 && options.level < images.NumLevels(), "the pyramids do not reach the level of matching");
}

}  // namespace

Result<TrackSet> Match(const ImageSet& images, const RigCalibration& calibration, const std::vector<Patch>& patches,
                       const MatchOptions& options, const Execution& execution) {
  CheckArguments(images, calibration, options);
  const std::vector<ViewGeometry> views = ViewGeometries(calibration);
  const MatchContext context{images, views, options};
  const std::vector<int> selected = SubsamplePatches(patches, views, images, options);
  const int num_selected = static_cast<int>(selected.size());
  const int num_chunks = (num_selected + kChunk - 1) / kChunk;

  std::vector<std::optional<Track>> tracks(selected.size());
  std::mutex reporting;
  int num_done = 0;
  const bool finished = ParallelFor(execution, num_chunks, [&](int chunk) {
    for (int i = chunk * kChunk; i < std::min(num_selected, (chunk + 1) * kChunk); ++i) {
      tracks[i] = MatchPatch(context, patches[selected[i]]);
    }
    const std::lock_guard lock(reporting);
    execution.Report(static_cast<double>(++num_done) / num_chunks);
  });
  if (!finished) return Cancelled("matching");

  TrackSet set;
  for (auto& track : tracks) {
    if (track) set.tracks.push_back(std::move(*track));
  }
  return set;
}

}  // namespace rigcal
