#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>

#include "config/formats/writers.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

// How cereal, which OpenMVG reads with, numbers pointers and types (sfm_data_io_cereal.cpp).
constexpr std::uint32_t kFirstUse = 0x80000000;
constexpr std::uint32_t kNotDerived = 0x40000000;

/// Numbers pointers and types in the order in which they are written.
class CerealIds {
 public:
  std::uint32_t NextPointer() { return kFirstUse | ++pointers_; }

  /// {"polymorphic_id", "polymorphic_name"}; the name only where the type comes for the first time.
  Json Type(const std::string& name) {
    for (std::size_t i = 0; i < types_.size(); ++i)
      if (types_[i] == name) return {{"polymorphic_id", i + 1}};
    types_.push_back(name);
    return {{"polymorphic_id", kFirstUse | static_cast<std::uint32_t>(types_.size())}, {"polymorphic_name", name}};
  }

 private:
  std::uint32_t pointers_ = 0;
  std::vector<std::string> types_;
};

Json ViewJson(const RigCalibration& calibration, int v, CerealIds& ids) {
  const View& view = calibration.views[v];
  const Camera& camera = calibration.CameraOf(v);
  const Json content = {{"local_path", ""},
                        {"filename", view.name},
                        {"width", camera.width_px},
                        {"height", camera.height_px},
                        {"id_view", v},
                        {"id_intrinsic", view.camera},
                        {"id_pose", v}};
  return {
      {"key", v},
      {"value", {{"polymorphic_id", kNotDerived}, {"ptr_wrapper", {{"id", ids.NextPointer()}, {"data", content}}}}}};
}

Json IntrinsicsJson(const Camera& camera, int c, CerealIds& ids) {
  Json content = {{"width", camera.width_px}, {"height", camera.height_px}, {"focal_length", camera.fx_px}};
  content["principal_point"] = {camera.cx_px, camera.cy_px};
  std::string type = "pinhole";
  if (camera.p1 != 0 || camera.p2 != 0) {
    type = "pinhole_brown_t2";
    content["disto_t2"] = {camera.k1, camera.k2, camera.k3, camera.p1, camera.p2};
  } else if (camera.HasDistortion()) {
    type = "pinhole_radial_k3";
    content["disto_k3"] = {camera.k1, camera.k2, camera.k3};
  }
  Json value = ids.Type(type);
  value["ptr_wrapper"] = {{"id", ids.NextPointer()}, {"data", content}};
  return {{"key", c}, {"value", value}};
}

Json PoseJson(const Rigid3d& cam_from_world, int v) {
  const Eigen::Matrix3d r = cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d centre = CentreInWorld(cam_from_world);
  Json rotation = Json::array();
  for (int row = 0; row < r.rows(); ++row) rotation.push_back({r(row, 0), r(row, 1), r(row, 2)});
  return {{"key", v}, {"value", {{"rotation", rotation}, {"center", {centre.x(), centre.y(), centre.z()}}}}};
}

}  // namespace

Result<ExportedFiles> OpenMvgFiles(const RigCalibration& calibration) {
  CerealIds ids;
  Json views = Json::array(), intrinsics = Json::array(), poses = Json::array();
  for (int v = 0; v < calibration.NumViews(); ++v) views.push_back(ViewJson(calibration, v, ids));
  for (int c = 0; c < calibration.NumCameras(); ++c)
    intrinsics.push_back(IntrinsicsJson(calibration.cameras[c], c, ids));
  for (int v = 0; v < calibration.NumViews(); ++v) poses.push_back(PoseJson(calibration.views[v].cam_from_world, v));
  const Json json = {{"sfm_data_version", "0.3"},      {"root_path", ""},     {"views", views},
                     {"intrinsics", intrinsics},       {"extrinsics", poses}, {"structure", Json::array()},
                     {"control_points", Json::array()}};
  return ExportedFiles{{"sfm_data.json", json.dump(1) + "\n"}};
}

}  // namespace rigcal
