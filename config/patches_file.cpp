#include "config/patches_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "config/atomic_file.h"
#include "config/text_fields.h"
#include "core/base/ensure.h"

namespace rigcal {
namespace {

static_assert(std::endian::native == std::endian::little, "patches.ply is written as the memory has it");

constexpr std::string_view kProperties =
    "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar views\nproperty float ncc\n"
    "end_header\n";
constexpr std::string_view kBeforeCount =
    "ply\nformat binary_little_endian 1.0\ncomment rigcal patches\nelement vertex ";
constexpr int kMostViews = 255;

constexpr std::size_t kFloats = 6, kBytes = 4;
constexpr std::size_t kVertexSize = (kFloats + 1) * sizeof(float) + kBytes;

void AppendVertex(const PatchVertex& vertex, std::string& bytes) {
  std::array<char, kVertexSize> record{};
  std::memcpy(record.data(), vertex.centre_in_world.data(), 3 * sizeof(float));
  std::memcpy(record.data() + 3 * sizeof(float), vertex.normal_in_world.data(), 3 * sizeof(float));
  const std::array<std::uint8_t, kBytes> small = {vertex.red, vertex.green, vertex.blue, vertex.num_views};
  std::memcpy(record.data() + kFloats * sizeof(float), small.data(), kBytes);
  std::memcpy(record.data() + kFloats * sizeof(float) + kBytes, &vertex.ncc, sizeof(float));
  bytes.append(record.data(), record.size());
}

PatchVertex VertexAt(const char* record) {
  PatchVertex vertex;
  std::memcpy(vertex.centre_in_world.data(), record, 3 * sizeof(float));
  std::memcpy(vertex.normal_in_world.data(), record + 3 * sizeof(float), 3 * sizeof(float));
  std::array<std::uint8_t, kBytes> small{};
  std::memcpy(small.data(), record + kFloats * sizeof(float), kBytes);
  vertex.red = small[0], vertex.green = small[1], vertex.blue = small[2], vertex.num_views = small[3];
  std::memcpy(&vertex.ncc, record + kFloats * sizeof(float) + kBytes, sizeof(float));
  return vertex;
}

PatchVertex VertexOf(const Patch& patch, const cv::Vec3b& bgr) {
  PatchVertex vertex;
  vertex.centre_in_world = patch.centre_in_world.cast<float>();
  vertex.normal_in_world = patch.normal_in_world.cast<float>();
  vertex.blue = bgr[0], vertex.green = bgr[1], vertex.red = bgr[2];
  vertex.num_views = static_cast<std::uint8_t>(std::min(static_cast<int>(patch.visible_views.size()), kMostViews));
  vertex.ncc = patch.ncc;
  return vertex;
}

/// BGR at a full-size pixel position: the nearest pixel of the picture that is kept, or the grey value.
cv::Vec3b ColourAt(const ViewImages& view, const Eigen::Vector2d& x_px) {
  const bool has_colour = !view.colour.empty();
  const Eigen::Vector2d x_level = has_colour ? Eigen::Vector2d(x_px / (1 << view.colour_level)) : x_px;
  const cv::Size size = has_colour ? view.colour.size() : view.SizePx();
  const int x = static_cast<int>(std::clamp(std::round(x_level.x()), 0.0, size.width - 1.0));
  const int y = static_cast<int>(std::clamp(std::round(x_level.y()), 0.0, size.height - 1.0));
  if (has_colour) return view.colour(y, x);
  return cv::Vec3b::all(cv::saturate_cast<unsigned char>(view.gray[0](y, x) * 255));
}

}  // namespace

std::vector<cv::Vec3b> PatchColours(const std::vector<Patch>& patches, const ImageSet& images,
                                    const RigCalibration& calibration) {
  std::vector<cv::Vec3b> colours(patches.size(), cv::Vec3b::all(0));
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const int v = patches[i].reference_view;
    const auto x_px =
        Project(Undistorted(calibration.CameraOf(v)), calibration.views[v].cam_from_world * patches[i].centre_in_world);
    if (x_px) colours[i] = ColourAt(images.views[v], *x_px);
  }
  return colours;
}

std::string PatchesPly(const std::vector<Patch>& patches, const std::vector<cv::Vec3b>& colours_bgr) {
  Ensure(patches.size() == colours_bgr.size(), "each patch has a colour");
  std::string bytes = fmt::format("{}{}\n{}", kBeforeCount, patches.size(), kProperties);
  bytes.reserve(bytes.size() + patches.size() * kVertexSize);
  for (std::size_t i = 0; i < patches.size(); ++i) AppendVertex(VertexOf(patches[i], colours_bgr[i]), bytes);
  return bytes;
}

Result<void> WritePatches(const std::filesystem::path& path, const std::vector<Patch>& patches,
                          const std::vector<cv::Vec3b>& colours_bgr) {
  return WriteFileAtomically(path, PatchesPly(patches, colours_bgr));
}

Result<std::vector<PatchVertex>> ParsePatches(std::string_view bytes, const std::string& file) {
  const std::size_t properties = bytes.find(kProperties);
  if (!bytes.starts_with(kBeforeCount) || properties == std::string_view::npos)
    return Fail(ErrorCode::kBadInput, "{}: is not a patches.ply of this program", file);
  const auto count = ParseCount(Trimmed(bytes.substr(kBeforeCount.size(), properties - kBeforeCount.size() - 1)), file);
  if (!count) return Fail(count.error());
  const std::string_view body = bytes.substr(properties + kProperties.size());
  if (body.size() != *count * kVertexSize)
    return Fail(ErrorCode::kBadInput, "{}: {} bytes follow the header, {} vertices have {}", file, body.size(), *count,
                *count * kVertexSize);
  std::vector<PatchVertex> vertices;
  for (int i = 0; i < *count; ++i) vertices.push_back(VertexAt(body.data() + i * kVertexSize));
  return vertices;
}

}  // namespace rigcal
