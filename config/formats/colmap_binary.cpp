#include <bit>
#include <cstdint>

#include "config/formats/colmap_camera.h"
#include "config/formats/colmap_rig.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

static_assert(std::endian::native == std::endian::little, "COLMAP's binary files are little endian");
constexpr std::int32_t kCameraSensor = 0;  // SensorType::CAMERA in src/colmap/util/types.h

/// Numbers one after the other, without any space between them.
class Bytes {
 public:
  template <typename T>
  Bytes& Add(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return *this;
  }
  void Add(const std::vector<double>& numbers) {
    for (double number : numbers) Add(number);
  }
  void AddWithZero(const std::string& word) { text_.append(word.c_str(), word.size() + 1); }
  void AddId(int index) { Add(static_cast<std::uint32_t>(ColmapId(index))); }
  void AddCount(std::size_t count) { Add(static_cast<std::uint64_t>(count)); }

  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string CamerasBytes(const RigCalibration& calibration) {
  Bytes bytes;
  bytes.AddCount(calibration.cameras.size());
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    const Camera& camera = calibration.cameras[c];
    const ColmapCamera colmap = ColmapCameraOf(camera);
    bytes.AddId(c);
    bytes.Add(static_cast<std::int32_t>(colmap.model_id));
    bytes.AddCount(camera.width_px);
    bytes.AddCount(camera.height_px);
    bytes.Add(colmap.parameters);
  }
  return bytes.Take();
}

std::string ImagesBytes(const RigCalibration& calibration) {
  Bytes bytes;
  bytes.AddCount(calibration.views.size());
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    bytes.AddId(v);
    bytes.Add(ColmapPose(view.cam_from_world));
    bytes.AddId(view.camera);
    bytes.AddWithZero(view.name);
    bytes.AddCount(0);  // features
  }
  return bytes.Take();
}

std::string RigsBytes(const ColmapRigs& rigs) {
  Bytes bytes;
  bytes.AddCount(rigs.rigs.size());
  for (std::size_t r = 0; r < rigs.rigs.size(); ++r) {
    const ColmapRig& rig = rigs.rigs[r];
    bytes.AddId(static_cast<int>(r));
    bytes.Add(static_cast<std::uint32_t>(rig.cameras.size()));
    bytes.Add(kCameraSensor).AddId(rig.cameras[0]);
    for (std::size_t i = 1; i < rig.cameras.size(); ++i) {
      bytes.Add(kCameraSensor).AddId(rig.cameras[i]);
      bytes.Add(std::uint8_t{1});  // a pose follows
      bytes.Add(ColmapPose(rig.sensor_from_rig[i]));
    }
  }
  return bytes.Take();
}

std::string FramesBytes(const ColmapRigs& rigs, const RigCalibration& calibration) {
  Bytes bytes;
  bytes.AddCount(rigs.frames.size());
  for (std::size_t f = 0; f < rigs.frames.size(); ++f) {
    const ColmapFrame& frame = rigs.frames[f];
    bytes.AddId(static_cast<int>(f));
    bytes.AddId(frame.rig);
    bytes.Add(ColmapPose(frame.rig_from_world));
    bytes.Add(static_cast<std::uint32_t>(frame.views.size()));
    for (int v : frame.views) {
      bytes.Add(kCameraSensor).AddId(calibration.views[v].camera);
      bytes.AddCount(ColmapId(v));
    }
  }
  return bytes.Take();
}

}  // namespace

Result<ExportedFiles> ColmapBinaryFiles(const RigCalibration& calibration) {
  ExportedFiles files = {{"cameras.bin", CamerasBytes(calibration)},
                         {"images.bin", ImagesBytes(calibration)},
                         {"points3D.bin", std::string(sizeof(std::uint64_t), '\0')}};
  if (const auto rigs = ColmapRigsOf(calibration)) {
    files["rigs.bin"] = RigsBytes(*rigs);
    files["frames.bin"] = FramesBytes(*rigs, calibration);
  }
  return files;
}

}  // namespace rigcal
