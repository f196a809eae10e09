#include "config/load_cameras.h"

#include <algorithm>
#include <cctype>

#include "config/calibration_file.h"
#include "config/camera_records.h"
#include "config/colmap_model.h"
#include "config/middlebury.h"
#include "config/text_fields.h"

namespace rigcal {
namespace {

Result<LoadedCameras> LoadColmap(const std::filesystem::path& folder, const CameraFileOptions& options) {
  const std::filesystem::path cameras = folder / "cameras.txt", images = folder / "images.txt";
  if (!std::filesystem::exists(cameras) && std::filesystem::exists(folder / "cameras.bin"))
    return Fail(ErrorCode::kUnsupported, "{}: is a binary COLMAP model; convert it to text (colmap model_converter)",
                folder.string());
  const Result<std::string> cameras_text = ReadFile(cameras), images_text = ReadFile(images);
  if (!cameras_text) return Fail(cameras_text.error());
  if (!images_text) return Fail(images_text.error());
  const auto records = ParseColmapModel(*cameras_text, *images_text, folder.string());
  if (!records) return Fail(records.error());
  Result<LoadedCameras> loaded = AssembleCameras(*records, images.string(), options);
  if (loaded) loaded->files = {{"cameras.txt", Sha256Hex(*cameras_text)}, {"images.txt", Sha256Hex(*images_text)}};
  return loaded;
}

/// Whether regrouping left cameras and views as the file has them, so that its covariance still belongs to them.
bool SameParameters(const RigCalibration& a, const RigCalibration& b) {
  return std::equal(
             a.cameras.begin(), a.cameras.end(), b.cameras.begin(), b.cameras.end(),
             [](const Camera& x, const Camera& y) { return x.id == y.id && x.Intrinsics() == y.Intrinsics(); }) &&
         std::equal(a.views.begin(), a.views.end(), b.views.begin(), b.views.end(),
                    [](const View& x, const View& y) { return x.name == y.name && x.camera == y.camera; });
}

/// What the caller does with a calibration.json: gather its views into cameras, or take it as it stands.
enum class OwnFile { kGathered, kAsItStands };

Result<LoadedCameras> LoadOwn(const std::string& text, const std::string& file, const CameraFileOptions& options,
                              OwnFile own) {
  const Result<CalibrationContent> content = ParseCalibration(text, file);
  if (!content) return Fail(content.error());
  Result<LoadedCameras> loaded = AssembleCameras(content->records, file, options);
  if (!loaded) return loaded;
  if (own == OwnFile::kAsItStands) {
    loaded->calibration = content->calibration;
    return loaded;
  }
  loaded->calibration.unit = content->calibration.unit;
  if (content->calibration.covariance && SameParameters(loaded->calibration, content->calibration)) {
    loaded->calibration.covariance = content->calibration.covariance;
  } else if (content->calibration.covariance) {
    loaded->notes.push_back(
        "the covariance of the camera file is not used: its views were gathered into other cameras");
  }
  return loaded;
}

Result<LoadedCameras> LoadMiddlebury(const std::string& text, const std::string& file,
                                     const CameraFileOptions& options) {
  const auto records = ParseMiddlebury(text, file);
  if (!records) return Fail(records.error());
  return AssembleCameras(*records, file, options);
}

Result<LoadedCameras> Load(const std::filesystem::path& path, const CameraFileOptions& options, OwnFile own) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return LoadColmap(path, options);
  const Result<std::string> text = ReadFile(path);
  if (!text) return Fail(text.error());
  const std::size_t begin = text->find_first_not_of(" \t\r\n");
  const char first = begin == std::string::npos ? '\0' : (*text)[begin];
  Result<LoadedCameras> loaded;
  if (first == '{') {
    loaded = LoadOwn(*text, path.string(), options, own);
  } else if (first == '\0' || std::isdigit(static_cast<unsigned char>(first)) != 0) {
    loaded = LoadMiddlebury(*text, path.string(), options);
  } else {
    return Fail(ErrorCode::kBadInput,
                "{}: is no camera file: neither a Middlebury par file, nor a COLMAP text model, nor a calibration.json",
                path.string());
  }
  if (loaded) loaded->files = {{path.filename().string(), Sha256Hex(*text)}};
  return loaded;
}

}  // namespace

Result<LoadedCameras> LoadCameras(const std::filesystem::path& path, const CameraFileOptions& options) {
  return Load(path, options, OwnFile::kGathered);
}

Result<LoadedCameras> LoadCamerasUnchanged(const std::filesystem::path& path, CameraFileOptions options) {
  options.intrinsics = IntrinsicsMode::kPerCamera;
  options.allow_skew = true;
  options.min_views = 1;
  const bool regrouped = !options.camera_from_name.empty() || !options.camera_by_image.empty();
  const OwnFile own = regrouped ? OwnFile::kGathered : OwnFile::kAsItStands;
  Result<LoadedCameras> loaded = Load(path, options, own);
  if (!loaded || !loaded->intrinsics_differ) return loaded;
  options.intrinsics = IntrinsicsMode::kPerView;
  return Load(path, options, own);
}

}  // namespace rigcal
