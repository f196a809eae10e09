#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string_view>

namespace rigcal {

/// A colour sensor's mosaic, named by the first row's first two pixels; the rows below and these take turns.
enum class Mosaic { kNone, kRG, kGR, kGB, kBG };

/// How a camera sends its pixels: names of GenICam's Pixel Format Naming Convention, unpacked Mono and Bayer formats.
struct PixelLayout {
  int bits = 8;  ///< 8, or 10, 12, 16 in the low bits of two bytes, the lower one first
  Mosaic mosaic = Mosaic::kNone;
};

/// Nothing for a format that pictures are not made of.
std::optional<PixelLayout> LayoutOf(std::string_view pixel_format);

/// Bytes that a picture of this layout takes.
std::size_t PictureBytes(const PixelLayout& layout, int width_px, int height_px);

/// The picture in a camera's bytes, rows one after the other without padding; at least PictureBytes() of them. CV_8U,
/// or CV_16U with 10 and 12 bits spread over the full scale: their bits repeated below, so that 0 stays 0 and the
/// largest value becomes 65535. Bayer mosaics become BGR (bilinear).
cv::Mat DecodePicture(const PixelLayout& layout, int width_px, int height_px, std::span<const std::uint8_t> bytes);

}  // namespace rigcal
