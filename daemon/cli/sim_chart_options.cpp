#include "daemon/cli/sim_chart_options.h"

#include <charconv>

#include "config/board_file.h"
#include "config/read_file.h"
#include "core/seed/tag_family.h"

namespace rigcal {
namespace {

Result<sim::ChartPrint> PrintFrom(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text) return Fail(text.error());
  const Result<Board> board = ParseBoard(*text, file.string());
  if (!board) return Fail(board.error());
  const Result<TagFamily> family = TagFamily::Make(board->family, board->border_bits);
  if (!family) return Fail(family.error());
  sim::ChartPrint print{*board, family->EdgeCells(), {}};
  for (int id = board->first_id; id < board->first_id + board->NumTags(); ++id)
    print.cells.push_back(family->Cells(id));
  return print;
}

/// All of `text` as a number.
template <typename Number>
std::optional<Number> NumberFrom(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

void AddSimChartOptions(CLI::App& command, SimChartRequest& request) {
  sim::ChartOptions& options = request.options;
  CLI::Option* chart = command.add_option(
      "--chart", request.file,
      "board.toml: this board lies on the table instead of the scene's object, under the same cameras");
  command.add_option("--bow-mm", request.bow_mm, "X[,Y]: height of the board's edges over its middle, along x and y")
      ->delimiter(',')
      ->needs(chart);
  command.add_option("--board-stretch", options.shape.stretch, "Print scale along x over that along y, minus one")
      ->capture_default_str()
      ->needs(chart);
  command
      .add_option("--board-tilt-deg", options.tilt_deg,
                  "The board lies on a wedge, its upper edge lifted: for cameras that see a flat one too flatly")
      ->capture_default_str()
      ->needs(chart);
  command
      .add_option("--hand-held", options.num_hand_held,
                  "More pictures per camera, camC_handNN.png, of the board held by hand; truth.json has their "
                  "cam_from_board, truth_par.txt leaves them out: they have no pose in the world")
      ->capture_default_str()
      ->needs(chart);
}

Result<std::optional<sim::ChartOptions>> ChartOf(const SimChartRequest& request) {
  if (request.file.empty()) return std::optional<sim::ChartOptions>();
  constexpr double kMetrePerMm = 1e-3;
  if (request.bow_mm.size() > 2) {
    return Fail(ErrorCode::kBadInput, "--bow-mm has {} values, at most 2 are known (x, y)", request.bow_mm.size());
  }
  Result<sim::ChartPrint> print = PrintFrom(request.file);
  if (!print) return Fail(print.error());
  sim::ChartOptions options = request.options;
  options.print = std::move(*print);
  if (!request.bow_mm.empty()) options.shape.bow_x_m = kMetrePerMm * request.bow_mm[0];
  if (request.bow_mm.size() > 1) options.shape.bow_y_m = kMetrePerMm * request.bow_mm[1];
  return std::optional(std::move(options));
}

Result<std::vector<IndexedNumber>> FaultsOf(const FaultOption& option, const std::vector<std::string>& given) {
  std::vector<IndexedNumber> faults;
  for (const std::string& text : given) {
    const std::size_t colon = text.find(':');
    std::string_view index = std::string_view(text).substr(0, colon);
    const std::string_view prefix = option.prefix;
    if (index.starts_with(prefix)) index.remove_prefix(prefix.size());
    const auto which = NumberFrom<int>(index);
    const auto number =
        colon == std::string::npos ? std::nullopt : NumberFrom<double>(std::string_view(text).substr(colon + 1));
    if (!which || !number) {
      return Fail(ErrorCode::kBadInput, "--{} is '{}', must be a number and {}, as 1:0.5", option.name, text,
                  option.number);
    }
    faults.push_back({*which, *number});
  }
  return faults;
}

}  // namespace rigcal
