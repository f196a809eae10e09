#include "config/formats/format_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "config/formats/writers.h"
#include "core/base/ensure.h"

namespace rigcal {
namespace {

constexpr std::string_view kCentre = "centre", kCorner = "corner";
constexpr std::string_view kOpenCvAxes = "x right, y down, z forward", kGlAxes = "x right, y up, z back";
constexpr std::string_view kUnverified =
    "nothing of its makers: a reader written from the format's description; **unverified in the program itself**";
constexpr std::string_view kUnverifiedCaveat =
    "the format is written from its description and was never read by its own program; check a picture before use";

constexpr FormatEntry kFormats[] = {
    {.format = ExportFormat::kMiddlebury,
     .name = "middlebury",
     .title = "Middlebury",
     .is_folder = false,
     .files = MiddleburyFiles,
     .gaps = kNoDistortion | kNamesAreWords,
     .published_name = "cameras_par.txt",
     .holds = "`*_par.txt` as above: K, R, t",
     .pixel_origin = "not stated by the format; centre is written",
     .axes = kOpenCvAxes,
     .verified = "a matrix product"},
    {.format = ExportFormat::kColmap,
     .name = "colmap",
     .title = "COLMAP",
     .is_folder = true,
     .files = ColmapTextFiles,
     .gaps = kNoSkew | kNamesAreWords | kNeedsSize,
     .holds = "`cameras.txt` (PINHOLE, OPENCV, or FULL_OPENCV when k3 is not 0), `images.txt`, empty `points3D.txt`; "
              "with a rig of several cameras `rigs.txt` and `frames.txt` (COLMAP 3.12; older ones leave them unread)",
     .pixel_origin = kCorner,
     .axes = kOpenCvAxes,
     .verified = "COLMAP 3.8 (its own reprojection error); rigs and frames: a reader written from COLMAP's source"},
    {.format = ExportFormat::kColmapBinary,
     .name = "colmap-bin",
     .title = "COLMAP (binary)",
     .is_folder = true,
     .files = ColmapBinaryFiles,
     .gaps = kNoSkew | kNeedsSize,
     .holds = "the same as `.bin`",
     .pixel_origin = kCorner,
     .axes = kOpenCvAxes,
     .verified = "as `colmap`"},
    {.format = ExportFormat::kPmvs,
     .name = "pmvs",
     .title = "PMVS",
     .is_folder = true,
     .files = PmvsFiles,
     .gaps = kNoDistortion,
     .holds = "`txt/%08d.txt`: `CONTOUR` and the 3x4 matrix P, its third row's direction of length 1; `views.txt` "
              "tells the image of each number",
     .pixel_origin = kCentre,
     .axes = kOpenCvAxes,
     .verified = "a matrix product"},
    {.format = ExportFormat::kOpenCv,
     .name = "opencv",
     .title = "OpenCV",
     .is_folder = false,
     .files = OpenCvFiles,
     .gaps = kNoSkew,
     .published_name = "opencv.yml",
     .holds = "FileStorage YAML: `unit`; `cameras`, a list of `id image_width image_height` (both only when known) "
              "`camera_matrix distortion_coefficients` (k1 k2 p1 p2 k3); `views`, a list of `name`, `camera` (index "
              "into `cameras`, from 0), `rvec`, `tvec` (world to camera)",
     .pixel_origin = kCentre,
     .axes = kOpenCvAxes,
     .verified = "OpenCV (cv::FileStorage, cv::projectPoints)"},
    {.format = ExportFormat::kKalibr,
     .name = "kalibr",
     .title = "Kalibr",
     .is_folder = false,
     .files = KalibrFiles,
     .gaps = kNoK3 | kNoSkew | kNeedsSize,
     .caveat = "Kalibr holds how the cameras stand to each other, not where the world is",
     .holds = "camchain YAML: pinhole and radtan (or none), `T_cn_cnm1` from the rig or, without one, from one view of "
              "each camera; no poses in the world",
     .pixel_origin = kCentre,
     .axes = kOpenCvAxes,
     .verified = "PyYAML, the model from Kalibr's description"},
    {.format = ExportFormat::kRos,
     .name = "ros",
     .title = "ROS camera_info",
     .is_folder = true,
     .files = RosFiles,
     .gaps = kNoSkew | kNeedsSize,
     .caveat = "ROS camera_info holds intrinsics, no poses",
     .holds = "`<camera>.yaml` for each camera: plumb_bob (k1 k2 p1 p2 k3); no poses",
     .pixel_origin = kCentre,
     .axes = kOpenCvAxes,
     .verified = "ROS's camera_calibration_parsers, cv::projectPoints"},
    {.format = ExportFormat::kNerfstudio,
     .name = "nerfstudio",
     .title = "nerfstudio",
     .is_folder = false,
     .files = NerfstudioFiles,
     .gaps = kNoK3 | kNoSkew | kNeedsSize,
     .holds = "`transforms.json` (instant-ngp reads it too): OPENCV, intrinsics of each frame, camera to world; no "
              "`applied_transform`: the world stays as it is",
     .pixel_origin = kCorner,
     .axes = kGlAxes,
     .verified = "json, the model from nerfstudio's description"},
    {.format = ExportFormat::kMetashape,
     .name = "metashape",
     .title = "Metashape",
     .is_folder = false,
     .files = MetashapeFiles,
     .gaps = kNeedsSize,
     .caveat = kUnverifiedCaveat,
     .holds = "cameras XML: a sensor for each camera (f cx cy b1 b2 k1 k2 k3 p1 p2; cx, cy from the picture's middle; "
              "p1, p2 are OpenCV's p2, p1), camera to chunk; the chunk is the world",
     .pixel_origin = kCorner,
     .axes = kOpenCvAxes,
     .verified = kUnverified},
    {.format = ExportFormat::kRealityCapture,
     .name = "realitycapture",
     .title = "RealityCapture",
     .is_folder = true,
     .files = RealityCaptureFiles,
     .gaps = kNoSkew | kOneFocalLength | kNeedsSize,
     .caveat = kUnverifiedCaveat,
     .holds = "`<image's stem>.xmp` for each view, to be put beside the pictures: perspective, brown3 or brown3t2 (t1, "
              "t2 are OpenCV's p2, p1), lengths over the longer side, rotation world to camera, position",
     .pixel_origin = kCorner,
     .axes = kOpenCvAxes,
     .verified = kUnverified},
    {.format = ExportFormat::kOpenMvg,
     .name = "openmvg",
     .title = "OpenMVG",
     .is_folder = true,
     .files = OpenMvgFiles,
     .gaps = kNoSkew | kOneFocalLength | kNeedsSize,
     .holds = "`sfm_data.json` 0.3: pinhole, pinhole_radial_k3 or pinhole_brown_t2; rotation world to camera, centre; "
              "`root_path` is empty",
     .pixel_origin = "not stated by the format; centre is written",
     .axes = kOpenCvAxes,
     .verified = "json, the model from OpenMVG's description"},
    {.format = ExportFormat::kMrcal,
     .name = "mrcal",
     .title = "mrcal",
     .is_folder = true,
     .files = MrcalFiles,
     .gaps = kNoSkew | kNeedsSize,
     .holds = "`<image's stem>.cameramodel` for each view: LENSMODEL_PINHOLE or LENSMODEL_OPENCV5, the world as common "
              "reference frame",
     .pixel_origin = kCentre,
     .axes = kOpenCvAxes,
     .verified = "mrcal's library (reading and projection)"},
    {.format = ExportFormat::kBundler,
     .name = "bundler",
     .title = "Bundler",
     .is_folder = true,
     .files = BundlerFiles,
     .gaps = kNoTangential | kNoK3 | kNoSkew | kOneFocalLength | kCentred | kNamesAreWords,
     .holds = "`bundle.out` v0.3 without points, `list.txt`: f k1 k2, world to camera",
     .pixel_origin = "the picture's middle, y up",
     .axes = kGlAxes,
     .verified = "COLMAP 3.8's own Bundler export of the same cameras, number by number; a reader written from "
                 "Bundler's description"},
};

}  // namespace

std::span<const FormatEntry> ExportFormats() {
  return kFormats;
}

const FormatEntry& EntryOf(ExportFormat format) {
  const FormatEntry& entry = kFormats[static_cast<std::size_t>(format)];
  Ensure(entry.format == format, "the table of formats is in the order of ExportFormat");
  return entry;
}

const FormatEntry* EntryNamed(std::string_view name) {
  const auto* found = std::ranges::find(kFormats, name, &FormatEntry::name);
  return found == std::end(kFormats) ? nullptr : found;
}

std::string FormatTableText() {
  std::string text =
      "| format | PATH | content | pixel (0,0) | camera axes | cannot say | verified by "
      "|\n|---|---|---|---|---|---|---|\n";
  for (const FormatEntry& entry : kFormats) {
    const std::string gaps = GapsText(entry.gaps);
    text += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", entry.name, entry.is_folder ? "folder" : "file",
                        entry.holds, entry.pixel_origin, entry.axes, gaps.empty() ? "-" : gaps, entry.verified);
  }
  return text;
}

}  // namespace rigcal
