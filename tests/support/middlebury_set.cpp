#include "tests/support/middlebury_set.h"

#include <Eigen/Geometry>
#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

namespace rigcal {
namespace {

ViewImages LoadPictures(const cv::Mat& gray, const std::string& name, int num_levels) {
  ViewImages pictures;
  pictures.name = name;
  cv::Mat1f full;
  gray.convertTo(full, CV_32F, 1.0 / 255);
  pictures.gray = BuildPyramid(full, num_levels);
  return pictures;
}

}  // namespace

std::optional<TestSet> LoadTestSet(const std::filesystem::path& folder, const std::filesystem::path& par,
                                   int num_levels, bool with_masks) {
  std::ifstream file(par);
  int count = 0;
  if (!(file >> count)) return std::nullopt;
  TestSet set;
  for (int i = 0; i < count; ++i) {
    std::string name;
    Eigen::Matrix<double, 21, 1> v;
    file >> name;
    for (double& value : v) file >> value;
    const cv::Mat gray = cv::imread((folder / name).string(), cv::IMREAD_GRAYSCALE);
    if (!file || gray.empty()) return std::nullopt;
    set.images.views.push_back(LoadPictures(gray, name, num_levels));
    ViewImages& pictures = set.images.views.back();
    if (with_masks) {
      const std::filesystem::path mask = folder / "masks" / std::filesystem::path(name).replace_extension(".png");
      pictures.mask = cv::imread(mask.string(), cv::IMREAD_GRAYSCALE);
    }
    Camera camera{.id = name, .physical_id = name, .width_px = gray.cols, .height_px = gray.rows};
    camera.fx_px = v[0], camera.skew_px = v[1], camera.cx_px = v[2], camera.fy_px = v[4], camera.cy_px = v[5];
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation(v.data() + 9);
    set.calibration.cameras.push_back(camera);
    set.calibration.views.push_back({name, i, {Eigen::Quaterniond(rotation), v.tail<3>()}});
    pictures.undistorted_with = camera;
  }
  return set;
}

std::optional<std::filesystem::path> RecordedSets() {
  const char* folder = std::getenv("RIGCAL_DATA");
  if (folder == nullptr) return std::nullopt;
  return std::filesystem::path(folder);
}

}  // namespace rigcal
