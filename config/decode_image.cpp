#include "config/decode_image.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

namespace rigcal {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n"sv;
constexpr std::string_view kJpegSignature = "\xff\xd8\xff"sv;

unsigned Byte(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}

/// Whether the chunks (length, type, content, checksum) go on to the last one, IEND.
bool PngIsComplete(std::string_view bytes) {
  constexpr std::size_t kAroundContent = 12;
  std::size_t at = kPngSignature.size();
  while (at + kAroundContent <= bytes.size()) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | Byte(bytes, at + i);
    const std::string_view type = bytes.substr(at + 4, 4);
    at += kAroundContent + length;
    if (type == "IEND") return at <= bytes.size();
  }
  return false;
}

/// First marker at or after the entropy-coded bytes from `at`: 0xFF that is neither stuffed (00) nor a restart (D0-D7).
std::size_t EndOfScan(std::string_view bytes, std::size_t at) {
  for (; at + 1 < bytes.size(); ++at) {
    if (Byte(bytes, at) != 0xff) continue;
    const unsigned next = Byte(bytes, at + 1);
    if (next != 0 && (next < 0xd0 || next > 0xd7)) return at;
  }
  return bytes.size();
}

/// Whether the segments go on to the end-of-image marker. Searching for its two bytes is not enough: an embedded
/// preview has one as well.
bool JpegIsComplete(std::string_view bytes) {
  constexpr unsigned kEndOfImage = 0xd9, kStartOfScan = 0xda, kFill = 0xff;
  std::size_t at = 2;
  while (at + 1 < bytes.size()) {
    const unsigned marker = Byte(bytes, at + 1);
    if (Byte(bytes, at) != 0xff || marker == kFill) {
      ++at;
      continue;
    }
    if (marker == kEndOfImage) return true;
    at += 2;
    if (at + 1 >= bytes.size()) return false;
    at += Byte(bytes, at) << 8 | Byte(bytes, at + 1);
    if (marker == kStartOfScan) at = EndOfScan(bytes, at);
  }
  return false;
}

bool IsComplete(std::string_view bytes) {
  if (bytes.starts_with(kPngSignature)) return PngIsComplete(bytes);
  if (bytes.starts_with(kJpegSignature)) return JpegIsComplete(bytes);
  return true;  // the decoders of the other formats complain themselves
}

}  // namespace

Result<cv::Mat> DecodeImage(const std::string& bytes, const std::string& file) {
  if (!IsComplete(bytes))
    return Fail(ErrorCode::kBadInput, "{}: the image is truncated, the file ends after {} bytes", file, bytes.size());
  cv::Mat image;
  try {
    if (!bytes.empty()) {
      const cv::Mat input(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
      image = cv::imdecode(input, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
    }
  } catch (const cv::Exception& error) {
    return Fail(ErrorCode::kBadInput, "{}: the image cannot be decoded ({})", file, error.err);
  }
  if (image.empty())
    return Fail(ErrorCode::kBadInput, "{}: is not an image that can be decoded, or it is truncated", file);
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    return Fail(ErrorCode::kUnsupported, "{}: pixels of 8 or 16 bits are needed, these have another format", file);
  return image;
}

cv::Mat1f GrayOf(const cv::Mat& image) {
  const double scale = image.depth() == CV_16U ? 1.0 / 65535 : 1.0 / 255;
  cv::Mat in_float;
  image.convertTo(in_float, CV_32F, scale);
  if (image.channels() == 1) return in_float;
  cv::Mat1f gray;
  cv::cvtColor(in_float, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

cv::Mat3b ColourOf(const cv::Mat& image, int level) {
  cv::Mat bytes = image, colour;
  if (image.depth() == CV_16U) image.convertTo(bytes, CV_8U, 255.0 / 65535);
  if (image.channels() == 1) {
    cv::cvtColor(bytes, colour, cv::COLOR_GRAY2BGR);
  } else {
    colour = bytes;
  }
  for (int l = 0; l < level; ++l) {
    cv::Mat smaller;
    cv::pyrDown(colour, smaller);
    colour = smaller;
  }
  return colour;
}

}  // namespace rigcal
