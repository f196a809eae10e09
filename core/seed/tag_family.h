#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

struct apriltag_family;

namespace rigcal {

/// The families that libapriltag knows, tag36h11 first.
std::span<const std::string_view> TagFamilyNames();

/// A family of libapriltag, with the border of the tags as wide as wanted. Cells are the squares that a tag is made of;
/// the square that is detected and that `tag_m` measures is EdgeCells() wide. Families with a reversed border (circles,
/// standard, custom) have a white square in a black one, and data outside of it too.
class TagFamily {
 public:
  /// Errors: kBadInput: a name that is not in TagFamilyNames(), border_bits outside [1, kMaxBorderBits], or more than
  /// one with a reversed border.
  static Result<TagFamily> Make(const std::string& name, int border_bits);

  [[nodiscard]] const std::string& Name() const { return name_; }
  [[nodiscard]] int NumCodes() const;
  [[nodiscard]] int EdgeCells() const;
  /// Edge of all that belongs to a tag: data outside of the square, or the white ring that it needs around it.
  [[nodiscard]] int TotalCells() const;
  [[nodiscard]] bool ReversedBorder() const;
  /// Cells between the edge of the square and the nearest data within it.
  [[nodiscard]] int BorderCells() const;
  /// How many wrong cells the code can stand without becoming another one.
  [[nodiscard]] int CorrectableCells() const;
  /// A tag as printed: TotalCells() x TotalCells(), 255 is white, row 0 is the upper one. `id` < NumCodes().
  [[nodiscard]] cv::Mat1b Cells(int id) const;
  /// For libapriltag; lives as long as this.
  [[nodiscard]] apriltag_family* Raw() const { return family_.get(); }

  static constexpr int kMaxBorderBits = 4;  ///< wider is in no use; Kalibr has 2

 private:
  using Owner = std::unique_ptr<apriltag_family, void (*)(apriltag_family*)>;
  TagFamily(std::string name, int border_bits, Owner family);

  std::string name_;
  int border_bits_;
  Owner family_;
};

}  // namespace rigcal
