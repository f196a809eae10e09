#include "core/seed/find_tags.h"

#include <apriltag/apriltag.h>

#include <algorithm>
#include <memory>
#include <tuple>

namespace rigcal {
namespace {

// Above this size edges are searched at half size: 12 megapixels take 0.4 instead of 1.9 s (measured). Corners are
// refined at full size later, so nothing is lost but tags of fewer than about 25 pixels, which are predicted.
constexpr int kFullSearchPixels = 4'000'000;
constexpr float kCoarseSearch = 2;

// libapriltag's table of codes with two wrong cells takes gigabytes for the families with tens of thousands of codes.
constexpr int kManyCodes = 3000;

struct DetectorOwner {
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
};

}  // namespace

Eigen::Vector2d FoundTag::Centre() const {
  return (corners_px[0] + corners_px[1] + corners_px[2] + corners_px[3]) / kCornersPerTag;
}

double FoundTag::ShortestEdgePx() const {
  double shortest = (corners_px[0] - corners_px[3]).norm();
  for (int i = 1; i < kCornersPerTag; ++i) shortest = std::min(shortest, (corners_px[i] - corners_px[i - 1]).norm());
  return shortest;
}

std::vector<FoundTag> FindTags(const cv::Mat1b& picture, const TagFamily& family) {
  const std::unique_ptr<apriltag_detector_t, DetectorOwner> detector(apriltag_detector_create());
  apriltag_detector_add_family_bits(detector.get(), family.Raw(), family.NumCodes() > kManyCodes ? 0 : 2);
  detector->nthreads = 1;
  detector->quad_decimate = picture.total() > kFullSearchPixels ? kCoarseSearch : 1;
  cv::Mat1b pixels = picture.clone();  // libapriltag takes a writable, contiguous picture
  image_u8_t image{.width = pixels.cols, .height = pixels.rows, .stride = pixels.cols, .buf = pixels.data};
  zarray_t* detections = apriltag_detector_detect(detector.get(), &image);
  std::vector<FoundTag> found;
  for (int i = 0; i < zarray_size(detections); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections, i, &detection);
    FoundTag& tag = found.emplace_back(FoundTag{.id = detection->id, .wrong_cells = detection->hamming});
    for (int k = 0; k < kCornersPerTag; ++k)
      tag.corners_px[k] = Eigen::Vector2d(detection->p[k][0], detection->p[k][1]).array() - kAprilTagPixelOffset;
  }
  apriltag_detections_destroy(detections);
  std::sort(found.begin(), found.end(), [](const FoundTag& a, const FoundTag& b) {
    return std::tuple(a.id, a.corners_px[0].x(), a.corners_px[0].y()) <
           std::tuple(b.id, b.corners_px[0].x(), b.corners_px[0].y());
  });
  return found;
}

}  // namespace rigcal
