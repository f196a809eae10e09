#include "config/rig_section.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "config/covariance_json.h"
#include "config/positioner_names.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kOrder =
    "for each camera fx fy cx cy skew k1 k2 p1 p2 k3, then for each camera a rotation (rad) about and a shift (m) "
    "along "
    "the camera's own x y z, then the same of anchor_from_world, then axes_in_stage column by column; rows not listed "
    "are 0";
constexpr int kMaxAxisNumbers = 9;

template <typename Value, std::size_t kCount>
Value ValueOf(const std::array<std::pair<std::string_view, Value>, kCount>& words, const Json& json, const char* key) {
  const auto given = json.at(key).get<std::string>();
  std::vector<std::string> known;
  for (const auto& [word, value] : words) {
    if (word == given) return value;
    known.emplace_back(word);
  }
  Refuse("rig: {} is '{}', must be one of {}", key, given, Joined(known, ", "));
}

std::vector<double> Numbers(const Json& json, const char* key, std::size_t count) {
  auto numbers = json.at(key).get<std::vector<double>>();
  if (numbers.size() != count) Refuse("rig: {} has {} numbers, {} are needed", key, numbers.size(), count);
  return numbers;
}

StopError ErrorSigmaFrom(const Json& json) {
  const std::vector<double> numbers = Numbers(json, "stop_error_sigma", kStopErrorSize);
  const StopError sigma = Eigen::Map<const StopError>(numbers.data());
  if ((sigma.array() < 0).any()) Refuse("rig: stop_error_sigma has a negative number");
  return sigma;
}

std::vector<std::optional<Rigid3d>> MountsFrom(const Json& json, const std::vector<Camera>& cameras,
                                               const std::string& file) {
  std::vector<std::optional<Rigid3d>> mounts(cameras.size());
  for (const Json& mount : List(json, "mounts")) {
    const auto id = mount.at("camera").get<std::string>();
    const auto camera = std::ranges::find(cameras, id, &Camera::id);
    if (camera == cameras.end()) Refuse("rig: mount of a camera '{}' that is not there", id);
    auto& place = mounts[static_cast<std::size_t>(camera - cameras.begin())];
    if (place) Refuse("rig: the camera '{}' is mounted twice", id);
    place = PoseFrom(mount.at("cam_from_mount"), "translation_m", fmt::format("{} mount of '{}'", file, id));
  }
  return mounts;
}

/// Refuses what is the covariance of nothing: negative variances, poses of which only some numbers are uncertain,
/// correlations that cannot be.
void CheckCovariance(const Eigen::MatrixXd& joint, int num_cameras) {
  std::vector<int> rows;
  for (int row = 0; row < static_cast<int>(joint.rows()); ++row) {
    if (joint(row, row) < 0) Refuse("rig: row {} of the covariance has the variance {}", row, joint(row, row));
    if (joint(row, row) > 0) rows.push_back(row);
  }
  constexpr int kPoseSize = 6;
  for (int first = RigCovariance::MountRow(num_cameras, 0); first < RigCovariance::AxesRow(num_cameras);
       first += kPoseSize) {
    const auto num_uncertain = (joint.diagonal().segment<kPoseSize>(first).array() > 0).count();
    if (num_uncertain != 0 && num_uncertain != kPoseSize)
      Refuse("rig: of the covariance's rows {} to {}, a pose, only {} are listed", first, first + kPoseSize - 1,
             num_uncertain);
  }
  const Eigen::MatrixXd listed = joint(rows, rows);
  const Eigen::VectorXd scale = listed.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> correlation(scale.asDiagonal() * listed * scale.asDiagonal());
  if (!rows.empty() && correlation.info() != Eigen::Success)
    Refuse("rig: the covariance is not positive definite: its correlations cannot be");
}

}  // namespace

Json RigSectionJson(const RigEstimate& rig, const std::vector<Camera>& cameras) {
  const Positioner& positioner = rig.model.positioner;
  Json json = {{"kind", WordOf(kPositionerKinds, positioner.kind)},
               {"carries", WordOf(kPositionerLoads, positioner.load)},
               {"axes", rig.axes}};
  json["stop_error_sigma"] = std::vector<double>(rig.model.error_sigma.begin(), rig.model.error_sigma.end());
  json["axis_scale_sigma"] = rig.model.axis_scale_sigma;
  json["anchor_from_world"] = PoseJson(positioner.anchor_from_world, "translation_m");
  const auto axes = positioner.axes_in_stage.reshaped();
  json["axes_in_stage"] = std::vector<double>(axes.begin(), axes.end());
  json["mounts"] = Json::array();
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (!rig.model.cam_from_mount[c]) continue;
    json["mounts"].push_back(
        {{"camera", cameras[c].id}, {"cam_from_mount", PoseJson(*rig.model.cam_from_mount[c], "translation_m")}});
  }
  json["covariance"] = CovarianceJson(rig.covariance.joint, kOrder);
  return json;
}

RigEstimate RigSectionFrom(const Json& json, const std::vector<Camera>& cameras, const std::string& file) {
  RigEstimate rig;
  Positioner& positioner = rig.model.positioner;
  positioner.kind = ValueOf(kPositionerKinds, json, "kind");
  positioner.load = ValueOf(kPositionerLoads, json, "carries");
  if (positioner.kind == PositionerKind::kTurntable && positioner.load != PositionerLoad::kObject)
    Refuse("rig: a turntable carries the object");
  rig.axes = json.at("axes").get<std::vector<std::string>>();
  positioner.num_axes = positioner.kind == PositionerKind::kGantry ? static_cast<int>(rig.axes.size()) : 0;
  const std::size_t most = positioner.kind == PositionerKind::kGantry ? kMaxGantryAxes : 1;
  const std::size_t least = positioner.kind == PositionerKind::kArm ? 0 : 1;
  if (rig.axes.size() < least || rig.axes.size() > (least == 0 ? 0 : most))
    Refuse("rig: {} axes of a {}", rig.axes.size(), WordOf(kPositionerKinds, positioner.kind));
  rig.model.error_sigma = ErrorSigmaFrom(json);
  rig.model.axis_scale_sigma = json.at("axis_scale_sigma").get<double>();
  positioner.anchor_from_world = PoseFrom(json.at("anchor_from_world"), "translation_m", file + " anchor_from_world");
  positioner.axes_in_stage = Eigen::Map<const Eigen::Matrix3d>(Numbers(json, "axes_in_stage", kMaxAxisNumbers).data());
  rig.model.cam_from_mount = MountsFrom(json, cameras, file);
  const int num_cameras = static_cast<int>(cameras.size());
  rig.covariance.joint = CovarianceFrom(json.at("covariance"), RigCovariance::Size(num_cameras));
  CheckCovariance(rig.covariance.joint, num_cameras);
  return rig;
}

}  // namespace rigcal
