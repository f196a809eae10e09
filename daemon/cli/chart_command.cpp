#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "config/atomic_file.h"
#include "config/board_file.h"
#include "config/board_pdf.h"
#include "config/read_file.h"
#include "daemon/cli/command.h"

namespace rigcal {
namespace {

constexpr double kMmPerM = 1000;

struct ChartArguments {
  std::string family = Board{}.family;
  int border_bits = 1, columns = 0, rows = 0, first_id = 0;
  double tag_mm = 0, gap_mm = 0, thickness_mm = 0;
  std::string page = "a4";
  std::filesystem::path out;

  [[nodiscard]] Board ToBoard() const {
    return {family, border_bits, columns, rows, tag_mm / kMmPerM, gap_mm / kMmPerM, first_id, thickness_mm / kMmPerM};
  }
};

Result<std::filesystem::path> PrintChart(const ChartArguments& arguments) {
  if (arguments.out.extension() != ".pdf")
    return Fail(ErrorCode::kBadInput, "--out {}: must end in .pdf", arguments.out.string());
  // What is written must be readable: the same checks as for a file.
  const Result<Board> board = ParseBoard(BoardText(arguments.ToBoard()), "board");
  if (!board) return Fail(board.error());
  const PaperSize paper = PaperFromName(arguments.page).value_or(PaperFor(*board));
  const Result<std::string> pdf = BoardPdf(*board, paper);
  if (!pdf) return Fail(pdf.error());
  const std::filesystem::path board_file = std::filesystem::path(arguments.out).replace_extension(".toml");
  // A scale measured on the print may stand in it.
  const Result<std::string> there = ReadFile(board_file);
  if (there && *there != BoardText(*board))
    return Fail(ErrorCode::kBadInput, "{}: is there already and describes another board; give another --out",
                board_file.string());
  if (const Result<void> written = SaveBoard(board_file, *board); !written) return Fail(written.error());
  if (const Result<void> written = WriteFileAtomically(arguments.out, *pdf); !written) return Fail(written.error());
  return board_file;
}

int RunChartPrint(const ChartArguments& arguments) {
  const Result<std::filesystem::path> board_file = PrintChart(arguments);
  if (!board_file) return FailWith("chart print", board_file.error());
  fmt::print("{} written; print it at 100 % and measure its ruler. {} goes to rigcal seed --chart\n",
             arguments.out.string(), board_file->string());
  return kExitAccepted;
}

}  // namespace

void AddChartCommand(CLI::App& app, CommandSession& session) {
  CLI::App* chart = app.add_subcommand("chart", "Boards of AprilTags");
  chart->require_subcommand(1);
  auto arguments = std::make_shared<ChartArguments>();
  CLI::App* print =
      chart->add_subcommand("print", "Writes a board as PDF, true to scale, and its board.toml beside it");
  print->add_option("--family", arguments->family, "Family of AprilTags")->capture_default_str();
  print->add_option("--border-bits", arguments->border_bits, "Width of the black border; 2: a Kalibr AprilGrid")
      ->capture_default_str();
  print->add_option("--columns", arguments->columns, "Tags across")->required();
  print->add_option("--rows", arguments->rows, "Tags up")->required();
  print->add_option("--tag-mm", arguments->tag_mm, "Edge of a tag's square")->required();
  print->add_option("--gap-mm", arguments->gap_mm, "Between the squares of neighbours")->required();
  print->add_option("--first-id", arguments->first_id, "Id of the lower left tag")->capture_default_str();
  print->add_option("--thickness-mm", arguments->thickness_mm, "From the print to the table under it")
      ->capture_default_str();
  print->add_option("--page", arguments->page, "Paper; custom: as large as the board needs")
      ->check(CLI::IsMember({"a4", "a3", "custom"}))
      ->capture_default_str();
  print->add_option("--out", arguments->out, "PDF to write")->required();
  print->callback([arguments, &session] { session.exit_status = RunChartPrint(*arguments); });
}

}  // namespace rigcal
