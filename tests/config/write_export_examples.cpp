// write_export_examples FOLDER: the cameras that tests/config/export_read_by_*.py export and read back, and where this
// program sees the points of an object: FOLDER/points.json and, for each example, NAME.json (a calibration) and
// NAME.pixels.json (view by view).
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "config/calibration_file.h"
#include "core/base/random.h"
#include "tests/config/export_examples.h"

int main(int argc, char** argv) {
  using namespace rigcal;
  using Json = nlohmann::ordered_json;
  if (argc != 2) return std::cerr << "write_export_examples FOLDER\n", 2;
  const std::filesystem::path folder = argv[1];
  Random random(11);
  std::vector<Eigen::Vector3d> x_in_world;
  Json points = Json::array();
  for (int i = 0; i < 200; ++i) {
    x_in_world.emplace_back(random.Uniform(-0.12, 0.12), random.Uniform(-0.12, 0.12), random.Uniform(-0.12, 0.12));
    points.push_back({x_in_world.back().x(), x_in_world.back().y(), x_in_world.back().z()});
  }
  std::ofstream(folder / "points.json") << points;
  for (const auto& [name, calibration] : ExportExamples()) {
    Json pixels = Json::array();
    for (int v = 0; v < calibration.NumViews(); ++v) {
      Json row = Json::array();
      for (const Eigen::Vector3d& x : x_in_world) {
        const auto x_px = Project(calibration.CameraOf(v), calibration.views[v].cam_from_world * x);
        row.push_back({x_px->x(), x_px->y()});
      }
      pixels.push_back(row);
    }
    std::ofstream(folder / (name + ".pixels.json")) << pixels;
    if (const auto written = WriteCalibration(folder / (name + ".json"), calibration, {}); !written)
      return std::cerr << written.error().message << "\n", 1;
  }
  return 0;
}
