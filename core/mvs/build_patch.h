#pragma once

#include <optional>
#include <vector>

#include "core/mvs/fit_plane.h"

namespace rigcal::stereo {

/// A patch while the surface is being grown.
struct SurfacePatch {
  Eigen::Vector3d centre_in_world;
  Eigen::Vector3d normal_in_world;
  int u_px = 0;  ///< the pixel of the reference view it was made for
  int v_px = 0;
  std::vector<Sighting> sightings;  ///< [0] is the reference view
  std::vector<Pixel> pixels;        ///< of each sighting: where its texture lies (inside the image), and the depth
  float ncc = 0;                    ///< MeanNcc() of the sightings
  float sigma_px = 0;               ///< of the fit, along the ray (PlaneFit); with free offsets mostly their prior
};

/// Mean over the sightings without the first, the reference; 0 without others.
float MeanNcc(const std::vector<Sighting>& sightings);

/// Whether two patches continue each other: |(c - c') . n| + |(c - c') . n'| < 2 rho (PMVS paper, section 2), rho being
/// a cell, and what wrong cameras add to it, at patch a.
bool AreNeighbours(const StereoScene& scene, const SurfacePatch& a, const SurfacePatch& b);

/// Where a point that is seen beside its projection by an offset is seen; nothing outside the image.
std::optional<Pixel> PixelInImage(const StereoScene& scene, const Eigen::Vector3d& x_in_world,
                                  const Sighting& sighting);

/// The other views that may see a surface point with this normal, the one with the smallest parallax to the reference
/// first: not too oblique, in front, inside the image and on the object.
std::vector<int> ViewsThatMaySee(const StereoScene& scene, int reference_view, const Eigen::Vector3d& point_in_world,
                                 const Eigen::Vector3d& normal_in_world, double max_obliqueness_rad);

/// Refines a plane on the views that agree with it, adds every further view that shows the same texture, and decides
/// whether that is a patch (number of views, mean NCC, parallax, precision). `hints` are sightings of a neighbour or of
/// a match; other views are looked for at no offset, or with free offsets by a search as wide as the cameras' errors.
std::optional<SurfacePatch> BuildPatch(const StereoScene& scene, const WindowPlane& start,
                                       const std::vector<Sighting>& hints);

}  // namespace rigcal::stereo
