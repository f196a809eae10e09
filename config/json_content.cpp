#include "config/json_content.h"

#include <cmath>
#include <limits>
#include <vector>

#include "config/camera_records.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

/// "(/cameras/0/fx_px) type must be number, but is string" of "[json.exception.type_error.302] (...".
std::string WithoutErrorNumber(const std::string& what) {
  const std::size_t end = what.starts_with("[json.exception.") ? what.find("] ") : std::string::npos;
  return end == std::string::npos ? what : what.substr(end + 2);
}

}  // namespace

int WholeNumber(const Json& json, int low, int high, const char* what) {
  const double number = json.get<double>();
  if (!(number >= low && number <= high) || number != std::floor(number))
    Refuse("{} is {}, a whole number from {} to {} is needed", what, number, low, high);
  return static_cast<int>(number);
}

Json PoseJson(const Rigid3d& b_from_a, const char* translation_key) {
  const Eigen::Quaterniond& q = b_from_a.rotation;
  const Eigen::Vector3d& t = b_from_a.translation;
  return {{"rotation", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}},
          {translation_key, {t.x(), t.y(), t.z()}}};
}

const Json& List(const Json& json, const char* key) {
  const Json& list = json.at(key);
  if (!list.is_array()) Refuse("{} is not a list", key);
  return list;
}

Rigid3d PoseFrom(const Json& json, const char* translation_key, const std::string& where) {
  const Json& q = json.at("rotation");
  const Result<Eigen::Quaterniond> rotation = RotationFromQuaternion(
      q.at("w").get<double>(), q.at("x").get<double>(), q.at("y").get<double>(), q.at("z").get<double>(), where);
  if (!rotation) throw BadContent(rotation.error().message);
  const auto t = json.at(translation_key).get<std::vector<double>>();
  if (t.size() != 3) Refuse("{}: the translation has {} numbers instead of 3", where, t.size());
  return {*rotation, Eigen::Vector3d(t[0], t[1], t[2])};
}

Result<void> CheckFormat(const Json& json, const std::string& file, const DocumentFormat& format) {
  if (!json.is_object()) return Fail(ErrorCode::kBadInput, "{}: is not a JSON object", file);
  if (json.at("format") != format.name)
    return Fail(ErrorCode::kBadInput, "{}: the format is not '{}'", file, format.name);
  if (const int version = WholeNumber(json.at("version"), 1, std::numeric_limits<int>::max(), "version");
      version > format.version)
    return Fail(ErrorCode::kUnsupported, "{}: has version {}, this program reads up to {}", file, version,
                format.version);
  return {};
}

tl::unexpected<Error> BadDocument(const std::string& file, const std::string& what) {
  const std::string message = WithoutErrorNumber(what);
  return Fail(ErrorCode::kBadInput, "{}", message.starts_with(file) ? message : file + ": " + message);
}

}  // namespace rigcal
