#include "drivers/genicam/decode_picture.h"

#include <array>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

struct FormatFamily {
  std::string_view name;  ///< the beginning of the format's name; its bits follow
  Mosaic mosaic;
};
constexpr std::array kFamilies = {
    FormatFamily{"Mono", Mosaic::kNone},  FormatFamily{"BayerRG", Mosaic::kRG}, FormatFamily{"BayerGR", Mosaic::kGR},
    FormatFamily{"BayerGB", Mosaic::kGB}, FormatFamily{"BayerBG", Mosaic::kBG},
};
constexpr std::array<std::pair<std::string_view, int>, 4> kBits = {{{"8", 8}, {"10", 10}, {"12", 12}, {"16", 16}}};

/// OpenCV names a mosaic by the second row's second and third pixel, GenICam by the first row's first two.
int DemosaicCode(Mosaic mosaic) {
  switch (mosaic) {
    case Mosaic::kRG:
      return cv::COLOR_BayerBG2BGR;
    case Mosaic::kGR:
      return cv::COLOR_BayerGB2BGR;
    case Mosaic::kGB:
      return cv::COLOR_BayerGR2BGR;
    default:
      return cv::COLOR_BayerRG2BGR;
  }
}

cv::Mat FullScale(const PixelLayout& layout, int width_px, int height_px, const std::uint8_t* bytes) {
  if (layout.bits == 8) {
    cv::Mat picture(height_px, width_px, CV_8U);
    std::memcpy(picture.ptr(), bytes, picture.total());
    return picture;
  }
  cv::Mat picture(height_px, width_px, CV_16U);
  std::memcpy(picture.ptr(), bytes, picture.total() * picture.elemSize());  // the host's order is the camera's
  const int up = 16 - layout.bits, down = layout.bits - up;
  const int mask = (1 << layout.bits) - 1;
  if (up > 0) {
    picture.forEach<std::uint16_t>([&](std::uint16_t& value, const int*) {
      const int kept = value & mask;
      value = static_cast<std::uint16_t>(kept << up | kept >> down);
    });
  }
  return picture;
}

}  // namespace

std::optional<PixelLayout> LayoutOf(std::string_view pixel_format) {
  for (const FormatFamily& family : kFamilies) {
    for (const auto& [name, bits] : kBits) {
      if (pixel_format.starts_with(family.name) && pixel_format.substr(family.name.size()) == name) {
        return PixelLayout{.bits = bits, .mosaic = family.mosaic};
      }
    }
  }
  return std::nullopt;
}

std::size_t PictureBytes(const PixelLayout& layout, int width_px, int height_px) {
  return static_cast<std::size_t>(width_px) * height_px * (layout.bits > 8 ? 2 : 1);
}

cv::Mat DecodePicture(const PixelLayout& layout, int width_px, int height_px, std::span<const std::uint8_t> bytes) {
  Ensure(bytes.size() >= PictureBytes(layout, width_px, height_px), "a picture is decoded when all of it is there");
  cv::Mat picture = FullScale(layout, width_px, height_px, bytes.data());
  if (layout.mosaic == Mosaic::kNone) return picture;
  cv::Mat colours;
  cv::cvtColor(picture, colours, DemosaicCode(layout.mosaic));
  return colours;
}

}  // namespace rigcal
