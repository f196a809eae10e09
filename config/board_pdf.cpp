#include "config/board_pdf.h"

#include <fmt/format.h>
#include <hpdf.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include "core/seed/check_board.h"
#include "core/seed/tag_family.h"

namespace rigcal {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kMmPerM = 1000;
constexpr double kMarginMm = 8;     // that office printers leave white on every side
constexpr double kStripMm = 16;     // ruler and caption, below the board or, turned, on its left
constexpr double kMinPaperMm = 60;  // across, for the caption's first words
constexpr double kMinRulerMm = 20, kMaxRulerMm = 200, kRulerStepMm = 10;
constexpr double kRulerTickMm = 5, kRulerLineMm = 0.2;
constexpr float kCaptionPoints = 7;
constexpr double kCaptionLineMm = 3;
constexpr double kRulerUpMm = 2 * kCaptionLineMm + 1;  // above the two lines of the caption

struct Size {
  double width_mm, height_mm;
};

double RulerMm(double room_mm) {
  return std::clamp(std::floor(room_mm / kRulerStepMm) * kRulerStepMm, kMinRulerMm, kMaxRulerMm);
}

// What is printed around the outer tags' squares: white ring, data outside of the square, or squares in the gaps'
// corners.
double RimMm(const Board& board, const TagFamily& family) {
  const double ring_m = (family.TotalCells() - family.EdgeCells()) / 2 * board.tag_m / family.EdgeCells();
  return kMmPerM * (board.border_bits > 1 ? std::max(board.gap_m, ring_m) : ring_m);
}

double AcrossMm(const Board& board, int tags) {
  return kMmPerM * (tags * board.tag_m + (tags - 1) * board.gap_m);
}

// Without the strip of ruler and caption.
Size NeededMm(const Board& board, const TagFamily& family) {
  const double around = 2 * (RimMm(board, family) + kMarginMm);
  return {AcrossMm(board, board.columns) + around, AcrossMm(board, board.rows) + around};
}

Result<TagFamily> FamilyOf(const Board& board) {
  if (const Result<void> checked = CheckBoard(board); !checked) return Fail(checked.error());
  return TagFamily::Make(board.family, board.border_bits);
}

/// Owns a document; libharu keeps the first error and ignores what follows.
struct DocumentOwner {
  void operator()(HPDF_Doc document) const { HPDF_Free(document); }
};
using Document = std::unique_ptr<std::remove_pointer_t<HPDF_Doc>, DocumentOwner>;

void AddRectangle(HPDF_Page page, double x_mm, double y_mm, double width_mm, double height_mm) {
  const auto points = [](double mm) { return static_cast<float>(mm * kPointsPerMm); };
  HPDF_Page_Rectangle(page, points(x_mm), points(y_mm), points(width_mm), points(height_mm));
}

// The black cells of one tag, runs of a row as one rectangle. All rectangles of a page are one path, which viewers fill
// without seams.
void AddTag(HPDF_Page page, const cv::Mat1b& cells, double x_mm, double y_mm, double cell_mm) {
  for (int row = 0; row < cells.rows; ++row) {
    for (int begin = 0; begin < cells.cols;) {
      int end = begin;
      while (end < cells.cols && cells(row, end) == cells(row, begin)) ++end;
      if (cells(row, begin) == 0)
        AddRectangle(page, x_mm + begin * cell_mm, y_mm + (cells.rows - 1 - row) * cell_mm, (end - begin) * cell_mm,
                     cell_mm);
      begin = end;
    }
  }
}

void AddBoard(HPDF_Page page, const Board& board, const TagFamily& family, const BoardPage& layout) {
  const double cell_mm = kMmPerM * board.tag_m / family.EdgeCells();
  const double outside_mm = (family.TotalCells() - family.EdgeCells()) / 2 * cell_mm;
  for (int id = board.first_id; id < board.first_id + board.NumTags(); ++id) {
    const Eigen::Vector3d lower_left_m = TagCornerInBoard(board, id, 0);
    AddTag(page, family.Cells(id), layout.board_x_mm + kMmPerM * lower_left_m.x() - outside_mm,
           layout.board_y_mm + kMmPerM * lower_left_m.y() - outside_mm, cell_mm);
  }
  if (board.border_bits == 1) return;
  const double gap_mm = kMmPerM * board.gap_m, pitch_mm = kMmPerM * board.tag_m + gap_mm;
  for (int row = 0; row <= board.rows; ++row)
    for (int column = 0; column <= board.columns; ++column)
      AddRectangle(page, layout.board_x_mm + column * pitch_mm - gap_mm, layout.board_y_mm + row * pitch_mm - gap_mm,
                   gap_mm, gap_mm);
}

// A rectangle of the strip: `along_mm` from its start, `up_mm` from its lower rim.
void AddToStrip(HPDF_Page page, const BoardPage& layout, double along_mm, double up_mm, double length_mm,
                double height_mm) {
  if (layout.strip_on_left)
    AddRectangle(page, kMarginMm + kStripMm - up_mm - height_mm, kMarginMm + along_mm, height_mm, length_mm);
  else
    AddRectangle(page, kMarginMm + along_mm, kMarginMm + up_mm, length_mm, height_mm);
}

// Ticks stand above the line; every tenth is as high as the ruler.
void AddRuler(HPDF_Page page, const BoardPage& layout) {
  AddToStrip(page, layout, -kRulerLineMm / 2, kRulerUpMm, layout.ruler_mm + kRulerLineMm, kRulerLineMm);
  for (int mm = 0; mm <= static_cast<int>(layout.ruler_mm); ++mm) {
    const double height_mm = kRulerTickMm * (mm % 10 == 0 ? 1 : mm % 5 == 0 ? 0.7 : 0.4);
    AddToStrip(page, layout, mm - kRulerLineMm / 2, kRulerUpMm, kRulerLineMm, height_mm);
  }
}

std::vector<std::string> Caption(const Board& board, const BoardPage& layout) {
  return {
      fmt::format(
          "{}, border {} bit, {} columns x {} rows, ids {} to {} from the lower left; tag {:.6g} mm, gap {:.6g} mm",
          board.family, board.border_bits, board.columns, board.rows, board.first_id,
          board.first_id + board.NumTags() - 1, kMmPerM * board.tag_m, kMmPerM * board.gap_m),
      fmt::format("Print at 100 %: the ruler is {:.0f} mm long, the outer edges of the tags span {:.6g} x {:.6g} mm",
                  layout.ruler_mm, AcrossMm(board, board.columns), AcrossMm(board, board.rows))};
}

void WriteCaption(HPDF_Doc document, HPDF_Page page, const std::vector<std::string>& lines, const BoardPage& layout) {
  HPDF_Page_BeginText(page);
  HPDF_Page_SetFontAndSize(page, HPDF_GetFont(document, "Helvetica", nullptr), kCaptionPoints);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double up_mm = static_cast<double>(lines.size() - 1 - i) * kCaptionLineMm + 1;
    const auto margin = static_cast<float>(kMarginMm * kPointsPerMm);
    const auto up = static_cast<float>(up_mm * kPointsPerMm), strip = static_cast<float>(kStripMm * kPointsPerMm);
    if (layout.strip_on_left)
      HPDF_Page_SetTextMatrix(page, 0, 1, -1, 0, margin + strip - up, margin);
    else
      HPDF_Page_SetTextMatrix(page, 1, 0, 0, 1, margin, margin + up);
    HPDF_Page_ShowText(page, lines[i].c_str());
  }
  HPDF_Page_EndText(page);
}

Result<std::string> Bytes(HPDF_Doc document) {
  HPDF_SaveToStream(document);
  if (const HPDF_STATUS error = HPDF_GetError(document); error != HPDF_OK)
    return Fail(ErrorCode::kIo, "board: the PDF cannot be made (libharu error {:#x})", error);
  std::string bytes(HPDF_GetStreamSize(document), '\0');
  auto size = static_cast<HPDF_UINT32>(bytes.size());
  HPDF_ReadFromStream(document, reinterpret_cast<HPDF_BYTE*>(bytes.data()), &size);
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::optional<PaperSize> PaperFromName(const std::string& name) {
  if (name == "a4") return PaperSize{"A4", 210, 297};
  if (name == "a3") return PaperSize{"A3", 297, 420};
  return std::nullopt;
}

PaperSize PaperFor(const Board& board) {
  const Result<TagFamily> family = FamilyOf(board);
  if (!family) return {"custom", 0, 0};
  const Size needed = NeededMm(board, *family);
  return {"custom", std::ceil(std::max(needed.width_mm, kMinPaperMm)), std::ceil(needed.height_mm + kStripMm)};
}

Result<BoardPage> LayOutBoard(const Board& board, const PaperSize& paper) {
  const Result<TagFamily> family = FamilyOf(board);
  if (!family) return Fail(family.error());
  const Size needed = NeededMm(board, *family);
  for (const Size page : {Size{paper.width_mm, paper.height_mm}, Size{paper.height_mm, paper.width_mm}}) {
    for (const bool strip_on_left : {false, true}) {
      const double left_mm = strip_on_left ? kStripMm : 0, below_mm = strip_on_left ? 0 : kStripMm;
      if (needed.width_mm + left_mm > page.width_mm || needed.height_mm + below_mm > page.height_mm) continue;
      return BoardPage{.width_mm = page.width_mm,
                       .height_mm = page.height_mm,
                       .board_x_mm = left_mm + (page.width_mm - left_mm - AcrossMm(board, board.columns)) / 2,
                       .board_y_mm = below_mm + (page.height_mm - below_mm - AcrossMm(board, board.rows)) / 2,
                       .ruler_mm = RulerMm((strip_on_left ? page.height_mm : page.width_mm) - 2 * kMarginMm),
                       .strip_on_left = strip_on_left};
    }
  }
  return Fail(
      ErrorCode::kBadInput,
      "the board needs {:.1f} x {:.1f} mm with its margins, and {:.0f} mm more on one side for the ruler, but {} has "
      "{:.0f} x {:.0f} mm",
      needed.width_mm, needed.height_mm, kStripMm, paper.name, paper.width_mm, paper.height_mm);
}

Result<std::string> BoardPdf(const Board& board, const PaperSize& paper) {
  const Result<BoardPage> layout = LayOutBoard(board, paper);
  if (!layout) return Fail(layout.error());
  const Result<TagFamily> family = FamilyOf(board);
  const Document document(HPDF_New(nullptr, nullptr));
  if (!document) return Fail(ErrorCode::kIo, "board: no memory for the PDF");
  HPDF_Page page = HPDF_AddPage(document.get());
  HPDF_Page_SetWidth(page, static_cast<float>(layout->width_mm * kPointsPerMm));
  HPDF_Page_SetHeight(page, static_cast<float>(layout->height_mm * kPointsPerMm));
  AddBoard(page, board, *family, *layout);
  AddRuler(page, *layout);
  HPDF_Page_Fill(page);
  WriteCaption(document.get(), page, Caption(board, *layout), *layout);
  return Bytes(document.get());
}

}  // namespace rigcal
