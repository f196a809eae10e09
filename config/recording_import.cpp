#include "config/recording_import.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <opencv2/core.hpp>
#include <optional>

#include "config/atomic_file.h"
#include "config/decode_image.h"
#include "config/name_pattern.h"
#include "config/read_file.h"
#include "config/recording_file.h"
#include "config/recording_writer.h"
#include "config/stop_angles.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOnlyCamera = "camera";  ///< as in camera files that name none
constexpr std::array kExtensions = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".pnm", ".webp"};

/// A picture and what its name tells.
struct NamedPicture {
  std::string file, camera;
  std::optional<std::string> stop;
};

bool IsPicture(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

/// Names of the pictures in a folder, sorted.
Result<std::vector<std::string>> PictureNames(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->is_regular_file(error) && IsPicture(it->path())) names.push_back(it->path().filename().string());
  if (error) return Fail(ErrorCode::kNotFound, "{}: cannot be read as a folder ({})", folder.string(), error.message());
  if (names.empty()) return Fail(ErrorCode::kNotFound, "{}: there is no picture in this folder", folder.string());
  std::sort(names.begin(), names.end());
  return names;
}

Result<std::vector<NamedPicture>> NamePictures(const PictureFolder& from) {
  const Result<std::vector<std::string>> names = PictureNames(from.folder);
  if (!names) return Fail(names.error());
  std::vector<NamedPicture> pictures;
  for (const std::string& name : *names) pictures.push_back({name, kOnlyCamera, std::nullopt});
  if (!from.camera_from_name.empty()) {
    const Result<NamePattern> camera = NamePattern::Parse(from.camera_from_name, "camera");
    if (!camera) return Fail(camera.error());
    for (NamedPicture& picture : pictures) {
      Result<std::string> id = camera->Find(picture.file);
      if (!id) return Fail(id.error());
      picture.camera = std::move(*id);
    }
  }
  if (!from.stop_from_name.empty()) {
    const Result<NamePattern> stop = NamePattern::Parse(from.stop_from_name, "stop");
    if (!stop) return Fail(stop.error());
    for (NamedPicture& picture : pictures) {
      Result<std::string> id = stop->Find(picture.file);
      if (!id) return Fail(id.error());
      picture.stop = std::move(*id);
    }
  }
  return pictures;
}

/// The stops in their order; those of a file of angles that have no picture are stops too.
Result<std::vector<RecordedStop>> StopsOf(const std::vector<NamedPicture>& pictures, const std::string& angles_deg) {
  std::vector<std::string> ids;
  for (const NamedPicture& picture : pictures)
    if (picture.stop && std::find(ids.begin(), ids.end(), *picture.stop) == ids.end()) ids.push_back(*picture.stop);
  SortStops(ids);
  std::map<std::string, double> angle_rad_by_stop;
  if (!angles_deg.empty()) {
    auto angles = StopAngles(angles_deg, ids);
    if (!angles) return Fail(angles.error());
    angle_rad_by_stop = std::move(*angles);
    for (const auto& [id, angle_rad] : angle_rad_by_stop)
      if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
    SortStops(ids);
  }
  std::vector<RecordedStop> stops;
  for (const std::string& id : ids) {
    stops.push_back({.id = id});
    if (const auto angle_rad = angle_rad_by_stop.find(id); angle_rad != angle_rad_by_stop.end())
      stops.back().axes.push_back({.axis = kTableAxis, .unit = AxisUnit::kRadian, .commanded = angle_rad->second});
  }
  return stops;
}

/// The camera's index; it is added with its first picture, which tells its size.
Result<int> CameraIndex(RecordingWriter& writer, const NamedPicture& picture, const fs::path& path, cv::Size size,
                        std::map<std::string, std::string>& first_picture_by_camera) {
  const std::vector<RecordedCamera>& cameras = writer.Content().cameras;
  const auto known = std::find_if(cameras.begin(), cameras.end(),
                                  [&](const RecordedCamera& camera) { return camera.id == picture.camera; });
  if (known == cameras.end()) {
    first_picture_by_camera[picture.camera] = picture.file;
    return writer.AddCamera({.id = picture.camera, .width_px = size.width, .height_px = size.height});
  }
  if (cv::Size(known->width_px, known->height_px) != size)
    return Fail(ErrorCode::kBadInput, "{}: the image is {} x {} px, '{}' of the same camera '{}' is {} x {} px",
                path.string(), size.width, size.height, first_picture_by_camera[picture.camera], picture.camera,
                known->width_px, known->height_px);
  return static_cast<int>(known - cameras.begin());
}

Result<void> CopyPictures(const PictureFolder& from, const std::vector<NamedPicture>& pictures, RecordingWriter& writer,
                          const Execution& execution) {
  std::map<std::string, int> stop_by_id;
  for (std::size_t s = 0; s < writer.Content().stops.size(); ++s)
    stop_by_id[writer.Content().stops[s].id] = static_cast<int>(s);
  std::map<std::string, std::string> first_picture_by_camera;
  for (const NamedPicture& picture : pictures) {
    if (execution.Stopped()) return Cancelled("importing pictures");
    const fs::path path = from.folder / picture.file;
    const Result<std::string> bytes = ReadFile(path);
    if (!bytes) return Fail(bytes.error());
    const Result<cv::Mat> image = DecodeImage(*bytes, path.string());
    if (!image) return Fail(image.error());
    const Result<int> camera = CameraIndex(writer, picture, path, image->size(), first_picture_by_camera);
    if (!camera) return Fail(camera.error());
    RecordedView view{.file = picture.file, .camera = *camera, .subject = from.subject};
    if (picture.stop) view.stop = stop_by_id.at(*picture.stop);
    if (Result<void> added = writer.AddView(std::move(view), *bytes); !added) return added;
    execution.Report(static_cast<double>(writer.Content().views.size()) / static_cast<double>(pictures.size()));
  }
  return {};
}

/// A hidden folder beside the one to be made, removed unless it became that one.
class StagingFolder {
 public:
  static Result<StagingFolder> Beside(const fs::path& out) {
    std::error_code error;
    if (fs::exists(out, error) && !(fs::is_directory(out, error) && fs::is_empty(out, error)))
      return Fail(ErrorCode::kBadInput, "{}: is there already and not empty; nothing is written over", out.string());
    if (Result<void> ready = PrepareOutputFolder(out.parent_path()); !ready) return Fail(ready.error());
    std::string name = (out.parent_path() / fmt::format(".{}.XXXXXX", out.filename().string())).string();
    if (mkdtemp(name.data()) == nullptr)
      return Fail(ErrorCode::kIo, "{}: no folder can be made beside it ({})", out.string(),
                  std::generic_category().message(errno));
    return StagingFolder(name);
  }
  StagingFolder(StagingFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  StagingFolder& operator=(StagingFolder&&) = delete;
  ~StagingFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }

  [[nodiscard]] const fs::path& Path() const { return path_; }

  Result<void> Become(const fs::path& out) {
    std::error_code error;
    constexpr auto kReadableByAll = fs::perms(0755);  // mkdtemp makes folders of mode 0700
    fs::permissions(path_, kReadableByAll, error);
    if (!error) fs::rename(path_, out, error);
    if (error) return Fail(ErrorCode::kIo, "{}: cannot be made ({})", out.string(), error.message());
    path_.clear();
    return {};
  }

 private:
  explicit StagingFolder(fs::path path) : path_(std::move(path)) {}
  fs::path path_;
};

/// The folder's absolute name without "." and a slash at its end.
fs::path Clean(const fs::path& folder) {
  fs::path clean = fs::absolute(folder).lexically_normal();
  return clean.has_filename() ? clean : clean.parent_path();
}

}  // namespace

Result<Recording> ImportRecording(const PictureFolder& pictures, const fs::path& out, const Execution& execution) {
  if (!pictures.angles_deg.empty() && pictures.stop_from_name.empty())
    return Fail(ErrorCode::kBadInput, "--angles-deg needs --stop-from-name: which picture belongs to which stop");
  const Result<std::vector<NamedPicture>> named = NamePictures(pictures);
  if (!named) return Fail(named.error());
  const Result<std::vector<RecordedStop>> stops = StopsOf(*named, pictures.angles_deg);
  if (!stops) return Fail(stops.error());
  const fs::path place = Clean(out);
  Result<StagingFolder> staging = StagingFolder::Beside(place);
  if (!staging) return Fail(staging.error());
  Result<RecordingWriter> writer = RecordingWriter::Create(staging->Path(), place.filename().string(), pictures.linear);
  if (!writer) return Fail(writer.error());
  for (const RecordedStop& stop : *stops)
    if (const Result<int> added = writer->AddStop(stop); !added) return Fail(added.error());
  if (Result<void> copied = CopyPictures(pictures, *named, *writer, execution); !copied) return Fail(copied.error());
  if (Result<void> closed = writer->Close(); !closed) return Fail(closed.error());
  if (Result<void> made = staging->Become(place); !made) return Fail(made.error());
  return writer->Content();
}

}  // namespace rigcal
