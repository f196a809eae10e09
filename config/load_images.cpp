#include "config/load_images.h"

#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "config/check_views.h"
#include "config/decode_image.h"
#include "config/mask_files.h"
#include "core/base/ensure.h"
#include "core/image/exposure.h"
#include "core/image/pyramid.h"
#include "core/image/silhouette.h"
#include "core/image/undistort.h"

namespace rigcal {
namespace {

/// One view on its way: what its own files give.
struct LoadedView {
  ViewImages images;
  std::vector<InputFile> files;  // the image, then the mask if there is one
};

std::string SizeText(cv::Size size) {
  return fmt::format("{} x {} px", size.width, size.height);
}

Result<void> CheckFits(const cv::Mat& image, const Camera& camera, const std::string& file) {
  const cv::Size expected(camera.width_px, camera.height_px);
  if (expected.width > 0 && expected.height > 0 && image.size() != expected)
    return Fail(ErrorCode::kBadInput, "{}: the image is {}, its camera '{}' is {}", file, SizeText(image.size()),
                camera.id, SizeText(expected));
  const double right = image.cols - 0.5, bottom = image.rows - 0.5;
  if (!(camera.cx_px >= -0.5 && camera.cx_px <= right && camera.cy_px >= -0.5 && camera.cy_px <= bottom))
    return Fail(ErrorCode::kBadInput,
                "{}: the principal point ({:.6g}, {:.6g}) px of camera '{}' lies outside the image of {}", file,
                camera.cx_px, camera.cy_px, camera.id, SizeText(image.size()));
  return {};
}

Result<cv::Mat1b> ReadMask(const std::filesystem::path& path, cv::Size size, const Camera& camera,
                           std::vector<InputFile>& files) {
  const Result<std::string> bytes = ReadFile(path);
  if (!bytes) return Fail(bytes.error());
  files.push_back({path.filename().string(), Sha256Hex(*bytes)});
  const Result<cv::Mat> image = DecodeImage(*bytes, path.string());
  if (!image) return Fail(image.error());
  if (image->size() != size)
    return Fail(ErrorCode::kBadInput, "{}: the mask is {}, its image is {}", path.string(), SizeText(image->size()),
                SizeText(size));
  cv::Mat gray = *image;
  if (image->channels() == 3) cv::cvtColor(*image, gray, cv::COLOR_BGR2GRAY);
  if (gray.depth() == CV_16U) gray.convertTo(gray, CV_8U, 255.0 / 65535);
  const cv::Mat object = gray >= kMaskThreshold;
  return Undistort(object, camera);
}

Result<LoadedView> LoadView(const std::filesystem::path& path, const View& view, const Camera& camera,
                            const std::optional<std::filesystem::path>& mask_path, const ImageOptions& options) {
  LoadedView loaded;
  loaded.images.name = view.name;
  loaded.images.undistorted_with = camera;
  const Result<std::string> bytes = ReadFile(path);
  if (!bytes) return Fail(bytes.error());
  loaded.files.push_back({view.name, Sha256Hex(*bytes)});
  if (const auto recorded = options.sha256_by_image.find(view.name); recorded != options.sha256_by_image.end()) {
    const Result<void> same = CheckSha256(loaded.files[0].sha256, recorded->second, path.string());
    if (!same) return Fail(same.error());
  }
  const Result<cv::Mat> image = DecodeImage(*bytes, path.string());
  if (!image) return Fail(image.error());
  if (const Result<void> fits = CheckFits(*image, camera, path.string()); !fits) return Fail(fits.error());
  loaded.images.gray = BuildPyramid(Undistort(GrayOf(*image), camera), options.num_levels);
  if (options.colour_level >= 0) {
    loaded.images.colour = ColourOf(Undistort(*image, camera), options.colour_level);
    loaded.images.colour_level = options.colour_level;
  }
  if (mask_path) {
    Result<cv::Mat1b> mask = ReadMask(*mask_path, image->size(), camera, loaded.files);
    if (!mask) return Fail(mask.error());
    loaded.images.mask = *mask;
  }
  loaded.images.undistorted_with.width_px = image->cols;
  loaded.images.undistorted_with.height_px = image->rows;
  return loaded;
}

/// Checks that a piece of hardware has one image size and fills it in where it is not known.
Result<void> FillInSizes(const std::vector<LoadedView>& views, RigCalibration& calibration) {
  std::map<std::string, int> first_view_by_hardware;
  for (int v = 0; v < calibration.NumViews(); ++v) {
    Camera& camera = calibration.cameras[calibration.views[v].camera];
    const cv::Size size = views[v].images.SizePx();
    const auto [first, is_new] = first_view_by_hardware.emplace(camera.physical_id, v);
    const cv::Size first_size = views[first->second].images.SizePx();
    if (size != first_size)
      return Fail(ErrorCode::kBadInput, "images of camera '{}' differ in size: '{}' is {}, '{}' is {}",
                  camera.physical_id, calibration.views[first->second].name, SizeText(first_size),
                  calibration.views[v].name, SizeText(size));
    camera.width_px = size.width;
    camera.height_px = size.height;
  }
  return {};
}

/// All views, each from its own files, in parallel; the Error is that of the first view that has one.
Result<std::vector<LoadedView>> LoadViews(const std::filesystem::path& folder, const RigCalibration& calibration,
                                          const std::vector<std::filesystem::path>& masks, const ImageOptions& options,
                                          const Execution& execution) {
  return ParallelResults<LoadedView>(execution, calibration.NumViews(), "loading the images", [&](int v) {
    const View& view = calibration.views[v];
    const auto mask = masks.empty() ? std::nullopt : std::optional(masks[v]);
    return LoadView(folder / view.name, view, calibration.CameraOf(v), mask, options);
  });
}

double ObjectShare(const cv::Mat1b& mask) {
  return static_cast<double>(cv::countNonZero(mask >= kMaskThreshold)) / static_cast<double>(mask.total());
}

MaskKind KindOf(Background background) {
  switch (background) {
    case Background::kDark:
      return MaskKind::kDarkBackground;
    case Background::kStatic:
      return MaskKind::kStaticBackground;
    case Background::kNone:
      break;
  }
  return MaskKind::kNone;
}

/// Silhouettes for `--masks auto`, found among all pictures of one piece of hardware.
void FindMasks(const RigCalibration& calibration, const Execution& execution, LoadedImages& loaded) {
  std::map<std::string, std::vector<int>> views_by_hardware;
  for (int v = 0; v < calibration.NumViews(); ++v) views_by_hardware[calibration.CameraOf(v).physical_id].push_back(v);
  for (const auto& [hardware, views] : views_by_hardware) {
    std::vector<cv::Mat1f> pictures;
    for (int v : views) pictures.push_back(loaded.images.views[v].gray[0]);
    const Silhouettes silhouettes = FindSilhouettes(pictures, execution);
    Ensure(silhouettes.masks.size() == views.size(), "there is one silhouette for each picture");
    for (std::size_t i = 0; i < views.size(); ++i) {
      loaded.images.views[views[i]].mask = silhouettes.masks[i];
      loaded.object_share[views[i]] = silhouettes.object_share[i];
      loaded.mask_kind[views[i]] = KindOf(silhouettes.background);
    }
  }
}

/// A picture whose object has no texture left cannot be matched. Only where a mask tells the object from a backdrop,
/// which may be white.
Result<void> CheckExposure(const std::filesystem::path& folder, const ImageSet& images) {
  for (const ViewImages& view : images.views) {
    if (view.mask.empty()) continue;
    const double share = SaturatedShare(view.gray[0], view.mask);
    if (share > kMaxSaturatedShare)
      return Fail(ErrorCode::kBadInput,
                  "{}: {:.0f} % of the object's pixels are saturated (limit {:.0f} %): over-exposed",
                  (folder / view.name).string(), 100 * share, 100 * kMaxSaturatedShare);
  }
  return {};
}

Result<std::vector<std::filesystem::path>> MaskFiles(const RigCalibration& calibration, const ImageOptions& options) {
  if (options.masks != MaskSource::kFolder) return std::vector<std::filesystem::path>();
  std::vector<std::string> names;
  for (const View& view : calibration.views) names.push_back(view.name);
  return FindMaskFiles(names, options.mask_folder, options.mask_from_name);
}

}  // namespace

const char* NameOf(MaskKind kind) {
  switch (kind) {
    case MaskKind::kFile:
      return "file";
    case MaskKind::kDarkBackground:
      return "dark";
    case MaskKind::kStaticBackground:
      return "static";
    case MaskKind::kNone:
      break;
  }
  return "none";
}

Result<LoadedImages> LoadImages(const std::filesystem::path& folder, RigCalibration& calibration,
                                const ImageOptions& options, const Execution& execution) {
  for (const View& view : calibration.views) {
    std::error_code error;
    if (!std::filesystem::exists(folder / view.name, error))
      return Fail(ErrorCode::kNotFound, "{}: there is no such image", (folder / view.name).string());
  }
  const auto masks = MaskFiles(calibration, options);
  if (!masks) return Fail(masks.error());
  Result<std::vector<LoadedView>> views = LoadViews(folder, calibration, *masks, options, execution);
  if (!views) return Fail(views.error());
  if (const Result<void> filled = FillInSizes(*views, calibration); !filled) return Fail(filled.error());
  if (const Result<void> meet = CheckViewsMeet(calibration); !meet) return Fail(meet.error());

  LoadedImages loaded;
  std::vector<InputFile> mask_files;
  for (LoadedView& view : *views) {
    const bool has_mask = !view.images.mask.empty();
    loaded.object_share.push_back(has_mask ? ObjectShare(view.images.mask) : 1.0);
    loaded.mask_kind.push_back(has_mask ? MaskKind::kFile : MaskKind::kNone);
    loaded.files.push_back(view.files[0]);
    if (has_mask) mask_files.push_back(view.files[1]);
    loaded.images.views.push_back(std::move(view.images));
  }
  loaded.files.insert(loaded.files.end(), mask_files.begin(), mask_files.end());
  if (options.masks == MaskSource::kAuto) FindMasks(calibration, execution, loaded);
  if (execution.Stopped()) return Cancelled("loading the images");
  if (const Result<void> exposed = CheckExposure(folder, loaded.images); !exposed) return Fail(exposed.error());
  return loaded;
}

}  // namespace rigcal
