#include "config/camera_records.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "config/json_text.h"
#include "config/name_pattern.h"

namespace rigcal {
namespace {

constexpr const char* kOnlyCamera = "camera";  // id of the physical camera when neither file nor option names one

Result<std::vector<std::string>> PhysicalIds(const std::vector<CameraRecord>& records,
                                             const CameraFileOptions& options) {
  std::vector<std::string> ids;
  if (!options.camera_by_image.empty()) {
    for (const CameraRecord& record : records) {
      const auto known = options.camera_by_image.find(record.name);
      if (known == options.camera_by_image.end())
        return Fail(ErrorCode::kBadInput, "{}: the recording has no picture '{}' of an object", record.where,
                    record.name);
      ids.push_back(known->second);
    }
    return ids;
  }
  if (options.camera_from_name.empty()) {
    for (const CameraRecord& record : records)
      ids.push_back(record.camera.physical_id.empty() ? kOnlyCamera : record.camera.physical_id);
    return ids;
  }
  const Result<NamePattern> naming = NamePattern::Parse(options.camera_from_name, "camera");
  if (!naming) return Fail(naming.error());
  for (const CameraRecord& record : records) {
    const Result<std::string> id = naming->Find(record.name);
    if (!id) return Fail(id.error());
    ids.push_back(*id);
  }
  return ids;
}

Result<void> CheckRecord(const CameraRecord& record, const CameraFileOptions& options) {
  if (record.name.empty() || record.name.size() > kMaxImageNameLength)
    return Fail(ErrorCode::kBadInput, "{}: an image name has 1 to {} characters, this one has {}", record.where,
                kMaxImageNameLength, record.name.size());
  const bool has_controls = std::ranges::any_of(record.name, [](unsigned char c) { return std::iscntrl(c) != 0; });
  if (has_controls || !IsUtf8(record.name))
    return Fail(ErrorCode::kBadInput, "{}: the image name '{}' is not plain text in UTF-8", record.where, record.name);
  if (!record.cam_from_world.translation.allFinite())
    return Fail(ErrorCode::kBadInput, "{}: holds a number that is not finite", record.where);
  return CheckIntrinsics(record.camera, record.where, options.allow_skew);
}

Result<void> CheckRecords(const std::vector<CameraRecord>& records, const std::string& file,
                          const CameraFileOptions& options) {
  std::map<std::string, std::string> where_by_name;
  for (const CameraRecord& record : records) {
    if (const Result<void> checked = CheckRecord(record, options); !checked) return checked;
    const auto [first, is_new] = where_by_name.emplace(record.name, record.where);
    if (!is_new)
      return Fail(ErrorCode::kBadInput, "{}: the same image name is already used at {}", record.where, first->second);
  }
  if (static_cast<int>(records.size()) < options.min_views)
    return Fail(ErrorCode::kBadInput, "{}: has {} views, at least {} are needed", file, records.size(),
                options.min_views);
  return {};
}

/// Median of each intrinsic parameter over the records; the mean of the middle two for an even number.
IntrinsicVector MedianIntrinsics(const std::vector<const CameraRecord*>& records) {
  IntrinsicVector median;
  for (int i = 0; i < kNumIntrinsics; ++i) {
    std::vector<double> values;
    for (const CameraRecord* record : records) values.push_back(record->camera.Intrinsics()[i]);
    std::sort(values.begin(), values.end());
    const double low = values[(values.size() - 1) / 2], high = values[values.size() / 2];
    median[i] = low == high ? low : 0.5 * (low + high);
  }
  return median;
}

Result<Camera> SharedCamera(const std::string& id, const std::vector<const CameraRecord*>& records,
                            LoadedCameras& loaded) {
  Camera camera = records.front()->camera;
  camera.id = camera.physical_id = id;
  for (const CameraRecord* record : records) {
    if (record->camera.width_px != camera.width_px || record->camera.height_px != camera.height_px)
      return Fail(ErrorCode::kBadInput, "{}: camera '{}' is {} x {} px here and {} x {} px at {}", record->where, id,
                  record->camera.width_px, record->camera.height_px, camera.width_px, camera.height_px,
                  records.front()->where);
  }
  const IntrinsicVector median = MedianIntrinsics(records);
  camera.SetIntrinsics(median);
  double spread_px = 0;
  bool differ = false;
  for (const CameraRecord* record : records) {
    const IntrinsicVector difference = (record->camera.Intrinsics() - median).cwiseAbs();
    spread_px = std::max(spread_px, difference.segment<4>(kFx).maxCoeff());
    differ = differ || difference.maxCoeff() > 0;
  }
  loaded.intrinsics_differ = loaded.intrinsics_differ || differ;
  if (differ)
    loaded.notes.push_back(
        fmt::format("camera '{}': its {} views come with differing intrinsics (up to {:.3g} px from their median); "
                    "starting from the median of each parameter",
                    id, records.size(), spread_px));
  loaded.max_intrinsics_spread_px = std::max(loaded.max_intrinsics_spread_px, spread_px);
  return camera;
}

void AssemblePerView(const std::vector<CameraRecord>& records, const std::vector<std::string>& physical_ids,
                     LoadedCameras& loaded) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    Camera camera = records[i].camera;
    camera.physical_id = physical_ids[i];
    camera.id = physical_ids[i] + "/" + records[i].name;
    loaded.calibration.cameras.push_back(camera);
    loaded.calibration.views.push_back({records[i].name, static_cast<int>(i), records[i].cam_from_world});
  }
}

Result<void> AssemblePerCamera(const std::vector<CameraRecord>& records, const std::vector<std::string>& physical_ids,
                               LoadedCameras& loaded) {
  std::vector<std::string> ids;  // in the order of first appearance
  std::map<std::string, std::vector<const CameraRecord*>> records_by_id;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const auto [group, is_new] = records_by_id.try_emplace(physical_ids[i]);
    if (is_new) ids.push_back(physical_ids[i]);
    group->second.push_back(&records[i]);
  }
  for (const std::string& id : ids) {
    const Result<Camera> camera = SharedCamera(id, records_by_id[id], loaded);
    if (!camera) return Fail(camera.error());
    loaded.calibration.cameras.push_back(*camera);
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    const auto index = std::find(ids.begin(), ids.end(), physical_ids[i]) - ids.begin();
    loaded.calibration.views.push_back({records[i].name, static_cast<int>(index), records[i].cam_from_world});
  }
  return {};
}

}  // namespace

Result<void> CheckIntrinsics(const Camera& camera, const std::string& where, bool allow_skew) {
  if (!camera.Intrinsics().allFinite())
    return Fail(ErrorCode::kBadInput, "{}: holds a number that is not finite", where);
  if (!(camera.fx_px > 0) || !(camera.fy_px > 0))
    return Fail(ErrorCode::kBadInput, "{}: the focal length {} x {} px must be above 0", where, camera.fx_px,
                camera.fy_px);
  if (!allow_skew && std::abs(camera.skew_px) > kMaxIgnoredSkewPx)
    return Fail(ErrorCode::kBadInput, "{}: a skew (k12) of {} px is above the limit of {} px", where, camera.skew_px,
                kMaxIgnoredSkewPx);
  return {};
}

Result<Eigen::Quaterniond> RotationFromMatrix(const Eigen::Matrix3d& matrix, const std::string& where) {
  const double error = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kMaxRotationError))
    return Fail(ErrorCode::kBadInput, "{}: not a rotation, R^T R differs from the identity by {:.3g} (limit {})", where,
                error, kMaxRotationError);
  if (matrix.determinant() < 0)
    return Fail(ErrorCode::kBadInput, "{}: not a rotation but a mirror image, its determinant is {:.3g}", where,
                matrix.determinant());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  return Eigen::Quaterniond(nearest).normalized();
}

Result<Eigen::Quaterniond> RotationFromQuaternion(double w, double x, double y, double z, const std::string& where) {
  const Eigen::Quaterniond quaternion(w, x, y, z);
  if (!(std::abs(quaternion.norm() - 1) <= kMaxRotationError))
    return Fail(ErrorCode::kBadInput, "{}: not a rotation, the quaternion's length is {:.6g} (1 within {})", where,
                quaternion.norm(), kMaxRotationError);
  return quaternion.normalized();
}

Result<LoadedCameras> AssembleCameras(const std::vector<CameraRecord>& records, const std::string& file,
                                      const CameraFileOptions& options) {
  if (const Result<void> checked = CheckRecords(records, file, options); !checked) return Fail(checked.error());
  const Result<std::vector<std::string>> physical_ids = PhysicalIds(records, options);
  if (!physical_ids) return Fail(physical_ids.error());
  LoadedCameras loaded;
  if (options.intrinsics == IntrinsicsMode::kPerView) {
    AssemblePerView(records, *physical_ids, loaded);
  } else if (const Result<void> assembled = AssemblePerCamera(records, *physical_ids, loaded); !assembled) {
    return Fail(assembled.error());
  }
  loaded.sizes_known = std::all_of(loaded.calibration.cameras.begin(), loaded.calibration.cameras.end(),
                                   [](const Camera& camera) { return camera.width_px > 0 && camera.height_px > 0; });
  if (!options.allow_skew)
    for (Camera& camera : loaded.calibration.cameras) camera.skew_px = 0;
  return loaded;
}

}  // namespace rigcal
