#include "sim_fixtures/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "core/seed/detect_chart.h"
#include "core/seed/tag_family.h"
#include "sim_fixtures/render.h"
#include "sim_fixtures/truth_file.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::Not;

Board SmallBoard() {
  return {.columns = 4, .rows = 3, .tag_m = 0.036, .gap_m = 0.011, .thickness_m = 0.005};
}

StudioOptions WithChart(const Board& board, const BoardShape& shape = {}) {
  const auto family = TagFamily::Make(board.family, board.border_bits);
  ChartPrint print{board, family->EdgeCells(), {}};
  for (int id = board.first_id; id < board.first_id + board.NumTags(); ++id) print.cells.push_back(family->Cells(id));
  StudioOptions options;
  options.scene = Scene::kMarker;
  options.cell_m = 0.001;
  options.num_stops = 2;
  options.width_px = 640;
  options.height_px = 480;
  options.distortion = {-0.12, 0.05, 0.0005, -0.0003, 0};
  options.chart = ChartOptions{.print = std::move(print), .shape = shape, .num_hand_held = 2};
  return options;
}

Studio MakeOrDie(const StudioOptions& options) {
  auto studio = MakeStudio(options, {});
  EXPECT_TRUE(studio.has_value()) << studio.error().message;
  return std::move(*studio);
}

/// Largest distance of a detected corner from where the truth projects it; `corners` counts them.
double LargestError_px(const Studio& studio, const RenderedView& rendered, const Camera& camera,
                       const Rigid3d& cam_from_board, std::size_t& corners) {
  const ChartOptions& chart = *studio.options.chart;
  const cv::Mat picture = Expose(rendered.radiance, {.noise_sigma = 0, .linear = true, .bits = 16}, 1);
  cv::Mat1f light;
  picture.convertTo(light, CV_32F, 1.0 / 65535);
  const auto found = DetectChart(light, chart.print.board, {.linear = true});
  EXPECT_TRUE(found.has_value()) << found.error().message;
  double largest_px = 0;
  for (const ChartCorner& corner : found->corners) {
    const Vector3d x_in_board = TagCornerInBoard(chart.print.board, chart.shape, corner.tag_id, corner.corner);
    largest_px = std::max(largest_px, (corner.x_px - *Project(camera, cam_from_board * x_in_board)).norm());
  }
  corners += found->corners.size();
  return largest_px;
}

void ExpectCornersWhereProjected(const StudioOptions& options, std::size_t least_corners) {
  constexpr int kSamples = 5;
  constexpr double kCornerError_px = 0.1;
  const Studio studio = MakeOrDie(options);
  std::size_t corners = 0;
  for (int view = 0; view < studio.truth.NumViews(); ++view) {
    const auto rendered = RenderView(studio, view, kSamples, {});
    const Rigid3d cam_from_board = studio.truth.views[view].cam_from_world * studio.chart->world_from_board;
    EXPECT_LT(LargestError_px(studio, *rendered, studio.truth.CameraOf(view), cam_from_board, corners), kCornerError_px)
        << studio.truth.views[view].name;
  }
  for (std::size_t i = 0; i < studio.chart->hand_held.size(); ++i) {
    const HandHeldView& view = studio.chart->hand_held[i];
    const auto rendered = RenderHandHeld(studio, static_cast<int>(i), kSamples, {});
    EXPECT_LT(LargestError_px(studio, *rendered, studio.truth.cameras[view.camera], view.cam_from_board, corners),
              kCornerError_px)
        << view.name;
  }
  EXPECT_GE(corners, least_corners);
}

/// The camera stands where the figurine is seen as a whole, and looks down on the board's wedge.
StudioOptions SeenFromAbove(StudioOptions options) {
  options.scene = Scene::kTextured;
  options.cell_m = 0.006;
  options.chart->tilt_deg = 25;
  return options;
}

TEST(Chart, CornersOfAFlatBoardAreWhereProjected) {
  ExpectCornersWhereProjected(SeenFromAbove(WithChart(SmallBoard())), 100);
}

// 3 mm of bow move corners by several pixels, in the hand and at the stops.
TEST(Chart, CornersOfABentAndStretchedBoardAreWhereProjected) {
  StudioOptions options =
      SeenFromAbove(WithChart(SmallBoard(), {.bow_x_m = 0.003, .bow_y_m = -0.002, .stretch = 0.01}));
  options.surroundings = Surroundings::kBackdrop;
  ExpectCornersWhereProjected(options, 100);
}

TEST(Chart, OtherFamiliesAndBordersArePrintedAsTheyAre) {
  Board kalibr = SmallBoard(), reversed = SmallBoard();
  kalibr.border_bits = 2;
  reversed.family = "tagStandard41h12";
  reversed.gap_m = 0.03;  // room for the data outside of the squares
  reversed.columns = 3, reversed.rows = 2;
  for (const Board& board : {kalibr, reversed}) {
    StudioOptions options = SeenFromAbove(WithChart(board));
    options.num_stops = 1;
    ExpectCornersWhereProjected(options, 60);
  }
}

// All of the print is ink or paper; a white margin of one cell is round the tags.
TEST(ChartMaterial, HasAMarginOfOneCell) {
  const StudioOptions options = WithChart(SmallBoard());
  const ChartPrint& print = options.chart->print;
  const double cell_m = print.board.tag_m / print.edge_cells;
  const Eigen::AlignedBox2d paper = PaperInBoard(print);
  EXPECT_NEAR(paper.min().x(), -cell_m, 1e-12);
  EXPECT_NEAR(paper.max().y(), 3 * print.board.tag_m + 2 * print.board.gap_m + cell_m, 1e-12);
  const ChartMaterial material(*options.chart, {});
  const Vector3d up = Vector3d::UnitZ();
  EXPECT_EQ(material.ReflectanceAt({-0.1 * cell_m, 0.1 * cell_m, 0}, up), ChartMaterial::kPaper);
  EXPECT_EQ(material.ReflectanceAt({0.1 * cell_m, 0.1 * cell_m, 0}, up), ChartMaterial::kInk);
  EXPECT_EQ(material.ReflectanceAt({0.1 * cell_m, 0.1 * cell_m, 0}, -up), ChartMaterial::kBoard);
}

TEST(PlaceChart, LiesOnTheTableNearTheAxis) {
  for (const double tilt_deg : {0.0, 30.0}) {
    StudioOptions options = WithChart(SmallBoard());
    options.chart->tilt_deg = tilt_deg;
    const Rigid3d place = PlaceChart(*options.chart, 3);
    const Vector3d centre_in_world = place * CentreInBoard(options.chart->print.board);
    EXPECT_LT(centre_in_world.head<2>().norm(), 0.006);
    const double tilted_deg = std::acos((place.rotation * Vector3d::UnitZ()).z()) * 180 / std::numbers::pi;
    EXPECT_NEAR(tilted_deg, tilt_deg, 0.8);
    float lowest_m = 1;
    for (const auto& x : ChartMesh(*options.chart, place).vertices_in_world) lowest_m = std::min(lowest_m, x.z());
    EXPECT_NEAR(lowest_m, 0, 1e-7);
    EXPECT_NE(PlaceChart(*options.chart, 4).translation, place.translation);
  }
}

TEST(Chart, LeavesTheCamerasWhereTheObjectHasThem) {
  StudioOptions options = WithChart(SmallBoard());
  const Studio chart = MakeOrDie(options);
  options.chart.reset();
  options.random_seed = 2;
  const Studio object = MakeOrDie(options);
  EXPECT_EQ(chart.cam_from_stage[0].translation, object.cam_from_stage[0].translation);
  EXPECT_EQ(chart.truth.views[1].cam_from_world.translation, object.truth.views[1].cam_from_world.translation);
}

TEST(Chart, SameBytesForOneAndTwoThreads) {
  StudioOptions options = WithChart(SmallBoard(), {.bow_x_m = 0.001});
  options.surroundings = Surroundings::kBackdrop;
  const Execution two{.stop = {}, .num_threads = 2, .report_progress = {}};
  const Studio alone = MakeOrDie(options);
  const auto together = MakeStudio(options, two);
  const auto a = RenderView(alone, 1, 3, {}), b = RenderView(*together, 1, 3, two);
  EXPECT_EQ(cv::norm(a->radiance, b->radiance, cv::NORM_INF), 0);
  const auto c = RenderHandHeld(alone, 1, 3, {}), d = RenderHandHeld(*together, 1, 3, two);
  EXPECT_EQ(cv::norm(c->radiance, d->radiance, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(c->coverage, d->coverage, cv::NORM_INF), 0);
}

TEST(HoldByHand, FillsThePictureTiltsAndReachesItsCorners) {
  StudioOptions options = WithChart(SmallBoard());
  options.chart->num_hand_held = 15;
  const Studio studio = MakeOrDie(options);
  const Board& board = options.chart->print.board;
  const Camera& camera = studio.truth.cameras[0];
  std::array<bool, 4> reached{};
  double most_tilt_deg = 0;
  for (const HandHeldView& view : studio.chart->hand_held) {
    double low = 1e9, high = -1e9;
    for (int id = 0; id < board.NumTags(); ++id) {
      for (int corner = 0; corner < kCornersPerTag; ++corner) {
        const Vector3d x_in_cam = view.cam_from_board * TagCornerInBoard(board, id, corner);
        const double y_px = camera.fy_px * x_in_cam.y() / x_in_cam.z();
        low = std::min(low, y_px), high = std::max(high, y_px);
        const Vector2d share = Project(camera, x_in_cam)->cwiseQuotient(Vector2d(camera.width_px, camera.height_px));
        const Vector2d from_rim = (share.array() < 0.5).select(share, Vector2d(1 - share.x(), 1 - share.y()));
        const bool at_rim = from_rim.minCoeff() > 0 && from_rim.maxCoeff() < 0.1;
        if (at_rim) reached[(share.x() < 0.5 ? 0 : 1) + (share.y() < 0.5 ? 0 : 2)] = true;
      }
    }
    EXPECT_GT((high - low) / camera.height_px, 0.3 - 1e-6) << view.name;
    EXPECT_LT((high - low) / camera.height_px, 0.9 + 1e-6) << view.name;
    const Vector3d sight = -(view.cam_from_board * CentreInBoard(board)).normalized();
    most_tilt_deg = std::max(most_tilt_deg, std::acos((view.cam_from_board.rotation * Vector3d::UnitZ()).dot(sight)) *
                                                180 / std::numbers::pi);
  }
  EXPECT_THAT(reached, testing::Each(true));
  EXPECT_GT(most_tilt_deg, 30);
  EXPECT_LT(most_tilt_deg, 60);  // 45 where it is held, more where its middle is seen from the side
}

TEST(Chart, TruthTellsItsShapePlaceAndHands) {
  const Studio studio = MakeOrDie(WithChart(SmallBoard(), {.bow_x_m = 0.001}));
  const std::string text = TruthText(studio, {});
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["chart"]["shape"]["bow_x_m"], 0.001);
  EXPECT_EQ(json["chart"]["world_from_board"]["translation_m"][2], studio.chart->world_from_board.translation.z());
  EXPECT_EQ(json["chart"]["hand_held"][1]["name"], "cam0_hand01.png");
  EXPECT_EQ(json["stops"].size(), 2U);
  EXPECT_THAT(StudioFromTruth(text, "a.json", {}).error().message, HasSubstr("a.json: is of a chart"));
}

TEST(Chart, RefusesWhatCannotBe) {
  const auto message = [](auto&& change) {
    StudioOptions options = WithChart(SmallBoard());
    change(*options.chart);
    return MakeStudio(options, {}).error().message;
  };
  EXPECT_THAT(message([](ChartOptions& c) { c.shape.bow_y_m = 0.02; }), HasSubstr("bow-mm is 20, must lie within -10"));
  EXPECT_THAT(message([](ChartOptions& c) { c.shape.stretch = std::nan(""); }), HasSubstr("board-stretch"));
  EXPECT_THAT(message([](ChartOptions& c) { c.tilt_deg = 90; }), HasSubstr("board-tilt-deg is 90"));
  EXPECT_THAT(message([](ChartOptions& c) { c.num_hand_held = -1; }), HasSubstr("hand-held is -1"));
}

}  // namespace
}  // namespace rigcal::sim
