#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/scene/board.h"
#include "core/seed/find_tags.h"

namespace rigcal {

enum class ChartFindingKind {
  kForeignIds,   ///< tags of the family that the board does not have; left out
  kDoubledIds,   ///< the same id at two places: two boards, or a reflection of one
  kMirrored,     ///< the picture or the print is a mirror image
  kLayout,       ///< ids do not run as the board file says
  kSpacing,      ///< tag and gap do not have the ratio that the board file says
  kOtherFamily,  ///< the tags belong to another family, or have another border
  kStrayTags,    ///< tags that do not lie where the board has them; left out
  kLostCorners,  ///< corners that could not be refined: hidden, blurred, over-exposed, at the rim
  kNothingSeen,  ///< no tag of the board
};

/// What is wrong with a chart in a picture, in one sentence.
struct ChartFinding {
  ChartFindingKind kind;
  std::string message;
  bool unusable = false;  ///< no corner of this picture may be used
};

/// The tags that agree with the board and with each other.
struct JudgedTags {
  std::vector<FoundTag> tags;
  std::set<int> stray_ids;  ///< found where the board does not have them
  std::vector<ChartFinding> findings;
};

/// Compares tags that were found with the board, each neighbour seen from a tag's own four corners: which ids belong to
/// it, whether they run as they should, whether the gap fits roughly, which tags hang together. Tags that stand alone
/// are left out when others hang together.
JudgedTags JudgeLayout(const Board& board, const std::vector<FoundTag>& found);

/// Pitch over edge may differ from the board's by this share. Refined corners of 20 tags tell it to 0.2 %; smaller
/// errors of the board file are left to the calibration, which sees all pictures.
inline constexpr double kSpacingTolerance = 0.03;

/// Whether the ratio of gap and edge is that of the board, by refined tags.
std::optional<ChartFinding> JudgeSpacing(const Board& board, const std::vector<FoundTag>& refined);

ChartFinding StrayTags(const std::set<int>& ids);

}  // namespace rigcal
