#include "core/seed/tag_family.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

struct KnownFamily {
  apriltag_family* (*create)();
  void (*destroy)(apriltag_family*);
};

constexpr std::array<std::string_view, 9> kNames = {"tag36h11",       "tag16h5",          "tag25h9",
                                                    "tag36h10",       "tagCircle21h7",    "tagCircle49h12",
                                                    "tagCustom48h12", "tagStandard41h12", "tagStandard52h13"};
constexpr std::array<KnownFamily, 9> kFamilies = {{{tag36h11_create, tag36h11_destroy},
                                                   {tag16h5_create, tag16h5_destroy},
                                                   {tag25h9_create, tag25h9_destroy},
                                                   {tag36h10_create, tag36h10_destroy},
                                                   {tagCircle21h7_create, tagCircle21h7_destroy},
                                                   {tagCircle49h12_create, tagCircle49h12_destroy},
                                                   {tagCustom48h12_create, tagCustom48h12_destroy},
                                                   {tagStandard41h12_create, tagStandard41h12_destroy},
                                                   {tagStandard52h13_create, tagStandard52h13_destroy}}};

std::string KnownNames() {
  std::string names;
  for (const std::string_view name : kNames) names.append(names.empty() ? "" : ", ").append(name);
  return names;
}

}  // namespace

std::span<const std::string_view> TagFamilyNames() {
  return kNames;
}

TagFamily::TagFamily(std::string name, int border_bits, Owner family)
    : name_(std::move(name)), border_bits_(border_bits), family_(std::move(family)) {}

Result<TagFamily> TagFamily::Make(const std::string& name, int border_bits) {
  const auto known = std::find(kNames.begin(), kNames.end(), name);
  if (known == kNames.end())
    return Fail(ErrorCode::kBadInput, "family: '{}' is not a family of AprilTags; known are {}", name, KnownNames());
  if (border_bits < 1 || border_bits > kMaxBorderBits)
    return Fail(ErrorCode::kBadInput, "border_bits: {} is outside 1 to {}", border_bits, kMaxBorderBits);
  const KnownFamily& maker = kFamilies[known - kNames.begin()];
  TagFamily made(name, border_bits, Owner(maker.create(), maker.destroy));
  apriltag_family& family = *made.family_;
  if (border_bits > 1 && family.reversed_border)
    return Fail(ErrorCode::kBadInput,
                "border_bits: {} is not possible with {}, whose border is a white ring of one bit", border_bits, name);
  const int wider = border_bits - 1;
  family.width_at_border += 2 * wider;
  family.total_width += 2 * wider;
  for (std::uint32_t i = 0; i < family.nbits; ++i) family.bit_x[i] += wider, family.bit_y[i] += wider;
  return made;
}

int TagFamily::NumCodes() const {
  return static_cast<int>(family_->ncodes);
}

int TagFamily::EdgeCells() const {
  return family_->width_at_border;
}

int TagFamily::TotalCells() const {
  return family_->total_width;
}

bool TagFamily::ReversedBorder() const {
  return family_->reversed_border;
}

int TagFamily::BorderCells() const {
  return border_bits_;
}

int TagFamily::CorrectableCells() const {
  return (static_cast<int>(family_->h) - 1) / 2;
}

cv::Mat1b TagFamily::Cells(int id) const {
  Ensure(id >= 0 && id < NumCodes(), "the family has a code of this id");
  const int total = TotalCells();
  const int origin = (total - EdgeCells()) / 2;
  const int ring = ReversedBorder() ? origin : origin - 1;
  cv::Mat1b cells(total, total, static_cast<uchar>(0));
  cv::rectangle(cells, {ring, ring}, {total - 1 - ring, total - 1 - ring}, 255);
  for (std::uint32_t i = 0; i < family_->nbits; ++i) {
    // Unsigned in libapriltag's header, but cells outside of the square count from -1 downwards.
    const int column = static_cast<int>(family_->bit_x[i]), row = static_cast<int>(family_->bit_y[i]);
    const bool white = (family_->codes[id] >> (family_->nbits - 1 - i)) & 1;
    cells(origin + row, origin + column) = white ? 255 : 0;
  }
  return cells;
}

}  // namespace rigcal
