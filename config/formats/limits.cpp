#include "config/formats/limits.h"

#include <cmath>
#include <vector>

#include "config/formats/conversions.h"

namespace rigcal {
namespace {

constexpr double kMaxOffCentrePx = 1e-9;  // rounding of a centred principal point
constexpr const char* kBlanks = " \t";
constexpr std::string_view kWayOut = "--undistorted writes the cameras of undistorted images";

Result<void> CheckLens(const Camera& camera, Gaps gaps, std::string_view title) {
  const auto refuse = [&](std::string_view what) {
    return Fail(ErrorCode::kUnsupported, "camera '{}' has {}, which {} cannot hold; {}", camera.id, what, title,
                kWayOut);
  };
  if ((gaps & kNoDistortion) != 0 && camera.HasDistortion()) return refuse("distortion");
  if ((gaps & kNoTangential) != 0 && (camera.p1 != 0 || camera.p2 != 0)) return refuse("distortion p1, p2");
  if ((gaps & kNoK3) != 0 && camera.k3 != 0) return refuse("distortion k3");
  return {};
}

Result<void> CheckPinhole(const Camera& camera, Gaps gaps, std::string_view title) {
  if ((gaps & kNoSkew) != 0 && camera.skew_px != 0)
    return Fail(ErrorCode::kUnsupported, "camera '{}' has a skew of {} px, which {} does not know", camera.id,
                camera.skew_px, title);
  if ((gaps & kOneFocalLength) != 0 && camera.fx_px != camera.fy_px)
    return Fail(ErrorCode::kUnsupported, "camera '{}' has fx = {} and fy = {} px, {} has one focal length; {}",
                camera.id, camera.fx_px, camera.fy_px, title, kWayOut);
  if ((gaps & kCentred) != 0) {
    const Eigen::Vector2d offset = PrincipalPointFromMiddlePx(camera);
    if (offset.cwiseAbs().maxCoeff() > kMaxOffCentrePx)
      return Fail(ErrorCode::kUnsupported,
                  "the principal point of camera '{}' is ({}, {}) px off the picture's middle, where {} has it; {}",
                  camera.id, offset.x(), offset.y(), title, kWayOut);
  }
  return {};
}

Result<void> CheckCamera(const Camera& camera, Gaps gaps, std::string_view title) {
  if ((gaps & (kNeedsSize | kCentred)) != 0 && (camera.width_px <= 0 || camera.height_px <= 0))
    return Fail(ErrorCode::kBadInput, "the image size of camera '{}' is not known, {} needs it", camera.id, title);
  if (Result<void> lens = CheckLens(camera, gaps, title); !lens) return lens;
  return CheckPinhole(camera, gaps, title);
}

}  // namespace

std::string GapsText(Gaps gaps) {
  constexpr std::pair<Gap, const char*> kWords[] = {{kNoDistortion, "distortion"},
                                                    {kNoTangential, "p1, p2"},
                                                    {kNoK3, "k3"},
                                                    {kNoSkew, "skew"},
                                                    {kOneFocalLength, "fx != fy"},
                                                    {kCentred, "a principal point off the middle"},
                                                    {kNamesAreWords, "blanks in image names"}};
  std::string text;
  for (const auto& [gap, words] : kWords) {
    if ((gaps & gap) == 0) continue;
    if (!text.empty()) text += ", ";
    text += words;
  }
  return text;
}

Result<void> CheckFits(const RigCalibration& calibration, Gaps gaps, std::string_view title) {
  for (const Camera& camera : calibration.cameras)
    if (Result<void> checked = CheckCamera(camera, gaps, title); !checked) return checked;
  for (const View& view : calibration.views)
    if ((gaps & kNamesAreWords) != 0 && view.name.find_first_of(kBlanks) != std::string::npos)
      return Fail(ErrorCode::kUnsupported, "the image name '{}' has blanks, which {} cannot hold", view.name, title);
  return {};
}

RigCalibration UndistortedFor(const RigCalibration& calibration, Gaps gaps) {
  RigCalibration undistorted = calibration;
  for (Camera& camera : undistorted.cameras) {
    camera = Undistorted(camera);
    if ((gaps & kOneFocalLength) != 0) camera.fx_px = camera.fy_px = std::sqrt(camera.fx_px * camera.fy_px);
    if ((gaps & kCentred) != 0 && camera.width_px > 0 && camera.height_px > 0) {
      const Eigen::Vector2d middle = MiddlePx(camera);
      camera.cx_px = middle.x(), camera.cy_px = middle.y();
    }
  }
  return undistorted;
}

}  // namespace rigcal
