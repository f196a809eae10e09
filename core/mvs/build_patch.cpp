#include "core/mvs/build_patch.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace rigcal::stereo {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Views of a fit see the patch less obliquely than this (PMVS paper, section 2: tau = 60 degrees); further views may
/// be a little worse, up to where a window is three times as long as wide.
constexpr double kMaxObliquenessOfFitRad = 60 * kDegree;
constexpr double kMaxObliquenessRad = 70 * kDegree;
/// Views of a first fit at most, nearest first, and of the final one: the precision grows with the parallax, the chance
/// to converge falls with it.
constexpr std::size_t kMaxViewsOfFirstFit = 4;
constexpr std::size_t kMaxViewsOfFinalFit = 8;
/// A view joins a fit from this NCC on, and stays, and is reported, from that NCC on.
constexpr float kMinNccToJoin = 0.3f;
constexpr float kMinNccToStay = 0.6f;
/// A view found by searching an offset has had many chances to correlate by accident.
constexpr float kMinNccOfSearched = 0.7f;
/// Least largest angle between the rays of a patch's views: below it a pixel of error is ten pixels of depth.
constexpr double kMinParallaxRad = 5 * kDegree;
constexpr double kMaxSigmaPx = 0.5;  ///< least precision of a patch along its ray, pixels of the level
constexpr int kFirstIterations = 6;
constexpr int kFinalIterations = 3;
/// The first fit ends where the second begins to converge quadratically, the second at a tenth of the precision that
/// textures give (0.1 px).
constexpr double kFirstConvergedPx = 0.15;
constexpr double kFinalConvergedPx = 0.03;

using Sightings = std::vector<Sighting>;

const Sighting* FindView(const Sightings& sightings, int view) {
  const auto it = std::find_if(sightings.begin(), sightings.end(), [&](const Sighting& s) { return s.view == view; });
  return it == sightings.end() ? nullptr : &*it;
}

/// How far a view's texture may lie from its projection: both views are off, single points twice the mean.
int SearchRadiusPx(const StereoScene& scene, int reference_view, int view) {
  constexpr double kPointsOverMean = 1.5;
  return static_cast<int>(
      std::ceil(kPointsOverMean * std::hypot(scene.views[reference_view].error_px, scene.views[view].error_px)));
}

/// The view's sighting at the plane as it is; nothing when it cannot show the window.
std::optional<Sighting> Look(const StereoScene& scene, const WindowPlane& plane, const WindowTexture& texture, int view,
                             const Sighting* hint) {
  const Eigen::Vector2f offset_px = hint != nullptr ? hint->offset_px : Eigen::Vector2f::Zero();
  const std::optional<WindowWarp> warp = MakeWarp(scene, plane, view, offset_px);
  if (!warp) return std::nullopt;
  const cv::Mat1f& gray = scene.views[view].gray;
  if (scene.free_offsets && hint == nullptr) {
    const std::optional<OffsetMatch> match =
        SearchOffset(gray, scene.options.window_px, *warp, texture, SearchRadiusPx(scene, plane.reference_view, view));
    if (!match) return std::nullopt;
    return Sighting{view, match->offset_px, match->ncc};
  }
  const std::optional<float> ncc = WindowNcc(gray, scene.options.window_px, *warp, texture);
  if (!ncc) return std::nullopt;
  return Sighting{view, offset_px, *ncc};
}

void DropBelow(float min_ncc, Sightings& sightings) {
  std::erase_if(sightings, [&](const Sighting& s) { return s.ncc < min_ncc; });
}

/// Adds views that are not in the fit yet and agree with it.
void AddFurtherViews(const StereoScene& scene, const WindowTexture& texture, PlaneFit& fit) {
  const Eigen::Vector3d centre = CentreInWorld(scene, fit.plane);
  const Eigen::Vector3d normal = NormalInWorld(scene, fit.plane);
  const float min_ncc = scene.free_offsets ? kMinNccOfSearched : kMinNccToStay;
  for (const int view : ViewsThatMaySee(scene, fit.plane.reference_view, centre, normal, kMaxObliquenessRad)) {
    if (FindView(fit.others, view) != nullptr) continue;
    const std::optional<Sighting> sighting = Look(scene, fit.plane, texture, view, nullptr);
    if (sighting && sighting->ncc >= min_ncc) fit.others.push_back(*sighting);
  }
}

double LargestParallaxRad(const StereoScene& scene, const PlaneFit& fit) {
  const Eigen::Vector3d centre = CentreInWorld(scene, fit.plane);
  const Eigen::Vector3d to_reference = scene.TowardsCamera(fit.plane.reference_view, centre);
  double smallest_cosine = 1;
  for (const Sighting& s : fit.others) {
    smallest_cosine = std::min(smallest_cosine, to_reference.dot(scene.TowardsCamera(s.view, centre)));
  }
  return std::acos(std::clamp(smallest_cosine, -1.0, 1.0));
}

/// With offsets the point that explains all positions best, the reference's as much as the others', is not on the
/// reference's ray: Gauss-Newton on the reprojection error, then every offset is taken from the new point.
void Triangulate(const StereoScene& scene, SurfacePatch& patch) {
  std::vector<Eigen::Vector2d> seen_px;
  for (const Sighting& s : patch.sightings) {
    const std::optional<Pixel> pixel = scene.Project(s.view, patch.centre_in_world);
    if (!pixel) return;
    seen_px.push_back(pixel->x_px + s.offset_px.cast<double>());
  }
  Eigen::Vector3d x = patch.centre_in_world;
  constexpr int kIterations = 2;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < seen_px.size(); ++i) {
      const auto& p = scene.views[patch.sightings[i].view].px_from_world;
      const Eigen::Vector3d q = p * x.homogeneous();
      const Eigen::Vector2d projected = q.head<2>() / q.z();
      const Eigen::Matrix<double, 2, 3> by_x = (p.topLeftCorner<2, 3>() - projected * p.block<1, 3>(2, 0)) / q.z();
      hessian += by_x.transpose() * by_x;
      gradient += by_x.transpose() * (projected - seen_px[i]);
    }
    x -= hessian.ldlt().solve(gradient);
  }
  std::vector<Eigen::Vector2f> offsets_px;
  for (std::size_t i = 0; i < seen_px.size(); ++i) {
    const std::optional<Pixel> pixel = scene.Project(patch.sightings[i].view, x);
    if (!pixel) return;
    offsets_px.emplace_back((seen_px[i] - pixel->x_px).cast<float>());
  }
  patch.centre_in_world = x;
  for (std::size_t i = 0; i < seen_px.size(); ++i) patch.sightings[i].offset_px = offsets_px[i];
}

/// Fills in the pixels; sightings outside their images go. False when too few are left.
bool Locate(const StereoScene& scene, SurfacePatch& patch) {
  const int reference_view = patch.sightings[0].view;
  std::erase_if(patch.sightings, [&](const Sighting& s) {
    const std::optional<Pixel> pixel = PixelInImage(scene, patch.centre_in_world, s);
    if (pixel) patch.pixels.push_back(*pixel);
    return !pixel;
  });
  return static_cast<int>(patch.sightings.size()) >= scene.options.min_views &&
         patch.sightings[0].view == reference_view;
}

bool FacesReference(const StereoScene& scene, const WindowPlane& plane) {
  const Eigen::Vector3d to_camera = scene.TowardsCamera(plane.reference_view, CentreInWorld(scene, plane));
  return NormalInWorld(scene, plane).dot(to_camera) > std::cos(kMaxObliquenessOfFitRad);
}

std::optional<SurfacePatch> AcceptedPatch(const StereoScene& scene, const PlaneFit& fit) {
  if (static_cast<int>(fit.others.size()) + 1 < scene.options.min_views) return std::nullopt;
  SurfacePatch patch;
  patch.sightings.push_back({fit.plane.reference_view, Eigen::Vector2f::Zero(), 1});
  patch.sightings.insert(patch.sightings.end(), fit.others.begin(), fit.others.end());
  patch.ncc = MeanNcc(patch.sightings);
  // Free offsets leave the depth to their prior, which is as wide as the cameras' errors.
  const double max_sigma_px = kMaxSigmaPx + scene.views[fit.plane.reference_view].error_px;
  if (patch.ncc < scene.options.min_ncc || fit.sigma_px > max_sigma_px) return std::nullopt;
  if (LargestParallaxRad(scene, fit) < kMinParallaxRad) return std::nullopt;
  if (!FacesReference(scene, fit.plane)) return std::nullopt;
  patch.centre_in_world = CentreInWorld(scene, fit.plane);
  patch.normal_in_world = NormalInWorld(scene, fit.plane);
  patch.sigma_px = static_cast<float>(fit.sigma_px);
  patch.u_px = fit.plane.u_px, patch.v_px = fit.plane.v_px;
  if (scene.free_offsets) Triangulate(scene, patch);
  if (!Locate(scene, patch)) return std::nullopt;
  return patch;
}

}  // namespace

float MeanNcc(const std::vector<Sighting>& sightings) {
  float sum = 0;
  for (std::size_t i = 1; i < sightings.size(); ++i) sum += sightings[i].ncc;
  return sightings.size() > 1 ? sum / static_cast<float>(sightings.size() - 1) : 0;
}

bool AreNeighbours(const StereoScene& scene, const SurfacePatch& a, const SurfacePatch& b) {
  const int view = a.sightings[0].view;
  constexpr double kErrorsApart = 2;  // the two patches may have been seen by different views
  const double rho = (scene.options.cell_px + kErrorsApart * scene.views[view].error_px) *
                     scene.FootprintInWorld(view, a.pixels[0].depth);
  const Eigen::Vector3d d = a.centre_in_world - b.centre_in_world;
  return std::abs(d.dot(a.normal_in_world)) + std::abs(d.dot(b.normal_in_world)) < 2 * rho;
}

std::optional<Pixel> PixelInImage(const StereoScene& scene, const Eigen::Vector3d& x_in_world,
                                  const Sighting& sighting) {
  std::optional<Pixel> pixel = scene.Project(sighting.view, x_in_world);
  if (!pixel) return std::nullopt;
  pixel->x_px += sighting.offset_px.cast<double>();
  const cv::Mat1f& image = scene.views[sighting.view].gray;
  if (!(pixel->x_px.x() >= 0 && pixel->x_px.y() >= 0 && pixel->x_px.x() <= image.cols - 1 &&
        pixel->x_px.y() <= image.rows - 1)) {
    return std::nullopt;
  }
  return pixel;
}

std::vector<int> ViewsThatMaySee(const StereoScene& scene, int reference_view, const Eigen::Vector3d& point_in_world,
                                 const Eigen::Vector3d& normal_in_world, double max_obliqueness_rad) {
  std::vector<std::pair<double, int>> by_parallax;
  const Eigen::Vector3d to_reference = scene.TowardsCamera(reference_view, point_in_world);
  const double min_cosine = std::cos(max_obliqueness_rad);
  for (int view = 0; view < scene.NumViews(); ++view) {
    if (view == reference_view) continue;
    const Eigen::Vector3d to_camera = scene.TowardsCamera(view, point_in_world);
    if (to_camera.dot(normal_in_world) < min_cosine) continue;
    const std::optional<Pixel> pixel = scene.Project(view, point_in_world);
    if (!pixel || !scene.CanHoldWindow(view, pixel->x_px)) continue;
    by_parallax.emplace_back(-to_reference.dot(to_camera), view);
  }
  std::sort(by_parallax.begin(), by_parallax.end());
  std::vector<int> views;
  for (const auto& [cosine, view] : by_parallax) views.push_back(view);
  return views;
}

std::optional<SurfacePatch> BuildPatch(const StereoScene& scene, const WindowPlane& start, const Sightings& hints) {
  const std::optional<WindowTexture> texture = ReferenceTexture(scene, start);
  if (!texture) return std::nullopt;
  const std::size_t min_others = static_cast<std::size_t>(scene.options.min_views - 1);
  PlaneFit fit{.plane = start, .others = {}, .sigma_px = 0};
  for (const int view : ViewsThatMaySee(scene, start.reference_view, CentreInWorld(scene, start),
                                        NormalInWorld(scene, start), kMaxObliquenessOfFitRad)) {
    const std::optional<Sighting> sighting = Look(scene, start, *texture, view, FindView(hints, view));
    if (sighting && sighting->ncc >= kMinNccToJoin) fit.others.push_back(*sighting);
    if (fit.others.size() >= std::max(kMaxViewsOfFirstFit, min_others)) break;
  }
  if (fit.others.size() < min_others) return std::nullopt;
  if (!FitPlane(scene, *texture, kFirstIterations, kFirstConvergedPx, fit)) return std::nullopt;
  if (!FacesReference(scene, fit.plane)) return std::nullopt;
  const std::size_t num_first = fit.others.size();
  DropBelow(kMinNccToStay, fit.others);
  if (fit.others.empty()) return std::nullopt;
  const bool has_lost_views = fit.others.size() < num_first;
  AddFurtherViews(scene, *texture, fit);
  if (fit.others.size() < min_others) return std::nullopt;
  // Nothing new: the first fit is the final one.
  if (!has_lost_views && fit.others.size() == num_first) return AcceptedPatch(scene, fit);
  Sightings beyond;
  if (fit.others.size() > kMaxViewsOfFinalFit) {
    beyond.assign(fit.others.begin() + kMaxViewsOfFinalFit, fit.others.end());
    fit.others.resize(kMaxViewsOfFinalFit);
  }
  if (!FitPlane(scene, *texture, kFinalIterations, kFinalConvergedPx, fit)) return std::nullopt;
  fit.others.insert(fit.others.end(), beyond.begin(), beyond.end());
  DropBelow(kMinNccToStay, fit.others);
  return AcceptedPatch(scene, fit);
}

}  // namespace rigcal::stereo
