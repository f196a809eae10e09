#include "core/seed/explain_absence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/seed/find_tags.h"

namespace rigcal {
namespace {

// So many tags with their code intact are no accident, even of a family with few bits.
constexpr int kMinTags = 3;
// Tags large enough to calibrate with are seen at this size too, and a dozen searches take a second.
constexpr std::size_t kMaxPixels = 1'500'000;
constexpr int kWhite = 250, kBright = 128, kBlack = 8;  // of 255: clipped, the brighter half, as good as black
constexpr double kMostOfBright =
    0.8;                             // share of the brighter half that is clipped from which it counts as over-exposed
constexpr double kAllBut = 0.98;     // share that is black from which it counts as dark: before a black cloth a
                                     // chart may well fill a tenth of it, not a fiftieth
constexpr double kSharpStep = 0.12;  // of white minus black, between neighbouring pixels: blur of about 3 px

int CountIntact(const cv::Mat1b& picture, const TagFamily& family) {
  const std::vector<FoundTag> tags = FindTags(picture, family);
  return static_cast<int>(
      std::count_if(tags.begin(), tags.end(), [](const FoundTag& tag) { return tag.wrong_cells == 0; }));
}

std::optional<ChartFinding> OtherTags(const cv::Mat1b& picture, const Board& board) {
  std::optional<ChartFinding> best;
  int most = kMinTags - 1;
  for (const std::string_view name : TagFamilyNames()) {
    for (const int border_bits : {1, 2}) {
      if (name == board.family && border_bits == board.border_bits) continue;
      const Result<TagFamily> family = TagFamily::Make(std::string(name), border_bits);
      if (!family) continue;
      const int count = CountIntact(picture, *family);
      if (count <= most) continue;
      most = count;
      best = ChartFinding{ChartFindingKind::kOtherFamily,
                          fmt::format("the picture shows {} tags of {} with border_bits {}, but the board file says {} "
                                      "with border_bits {}",
                                      count, name, border_bits, board.family, board.border_bits),
                          true};
    }
  }
  return best;
}

double Share(const cv::Mat& mask) {
  return static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total());
}

// The largest step between neighbouring pixels, as a share of the picture's own range.
double SteepestStep(const cv::Mat1b& picture) {
  double darkest = 0, brightest = 0, steepest = 0;
  cv::minMaxLoc(picture, &darkest, &brightest);
  cv::Mat smooth, gradient;
  cv::GaussianBlur(picture, smooth, {3, 3}, 0);
  cv::Sobel(smooth, gradient, CV_32F, 1, 0, 1, 0.5);
  cv::minMaxLoc(cv::abs(gradient), nullptr, &steepest);
  return brightest > darkest ? steepest / (brightest - darkest) : 0;
}

}  // namespace

ChartFinding ExplainAbsence(const cv::Mat1b& picture, const Board& board) {
  cv::Mat1b encoded = picture;
  while (encoded.total() > kMaxPixels) cv::pyrDown(encoded, encoded);
  const Result<TagFamily> family = TagFamily::Make(board.family, board.border_bits);
  cv::Mat1b mirrored;
  cv::flip(encoded, mirrored, 1);
  if (const int count = family ? CountIntact(mirrored, *family) : 0; count >= std::min(kMinTags, board.NumTags()))
    return {ChartFindingKind::kMirrored,
            fmt::format("{} tags can be read in the mirror image: the picture or the print is mirrored", count), true};
  if (std::optional<ChartFinding> other = OtherTags(encoded, board)) return *std::move(other);
  const double black = Share(cv::Mat(encoded <= kBlack)), step = SteepestStep(encoded);
  const double bright = Share(cv::Mat(encoded >= kBright));
  const double clipped = bright > 1 - kAllBut ? Share(cv::Mat(encoded >= kWhite)) / bright : 0;
  std::string why = "no tag of the board is seen";
  if (black > kAllBut)
    why += fmt::format("; {:.0f} % of the picture is black", 100 * black);
  else if (clipped > kMostOfBright)
    why += fmt::format("; the picture is over-exposed, {:.0f} % of its bright parts are white", 100 * clipped);
  else if (step < kSharpStep)
    why += fmt::format(
        "; the picture is blurred (its steepest step between pixels is {:.0f} % of its range, sharp ones "
        "have {:.0f} %)",
        100 * step, 100 * kSharpStep);
  return {ChartFindingKind::kNothingSeen, why, true};
}

}  // namespace rigcal
