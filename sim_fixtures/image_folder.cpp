#include "sim_fixtures/image_folder.h"

#include <fstream>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <system_error>

#include "core/base/random.h"
#include "sim_fixtures/files.h"

namespace rigcal::sim {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNoiseTask = 1000;    ///< DeriveSeed: + view
constexpr std::uint64_t kDisturbTask = 5000;  ///< DeriveSeed: + index of the target
constexpr int kMinViewsOfPoint = 2;           ///< fewer say nothing about how cameras stand to each other

Result<void> MakeFolder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return Fail(ErrorCode::kIo, "{}: the folder cannot be made ({})", folder.string(), failed.message());
  return {};
}

Result<void> WritePng(const fs::path& file, const cv::Mat& picture) {
  constexpr int kCompression = 1;  // noise does not shrink further, and takes longer
  std::vector<std::uint8_t> bytes;
  try {
    cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, kCompression});
  } catch (const cv::Exception& error) {
    return Fail(ErrorCode::kIo, "{}: cannot be encoded ({})", file.string(), error.what());
  }
  return WriteWhole(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Result<void> WriteView(const Studio& studio, int view, const FolderOptions& options, const fs::path& folder,
                       const Execution& execution) {
  const auto rendered = RenderView(studio, view, options.samples_per_side, execution);
  if (!rendered) return Fail(rendered.error());
  const std::uint64_t seed = DeriveSeed(studio.options.random_seed, kNoiseTask + static_cast<std::uint64_t>(view));
  const std::string& name = studio.truth.views[view].name;
  if (auto written = WritePng(folder / name, Expose(rendered->radiance, options.sensor, seed)); !written) {
    return written;
  }
  return WritePng(folder / "masks" / name, MaskOf(*rendered));
}

/// All views, on the execution's threads; the first failure by view number is reported.
Result<void> WriteViews(const Studio& studio, const FolderOptions& options, const fs::path& folder,
                        const Execution& execution) {
  const int count = studio.truth.NumViews();
  std::vector<std::optional<Error>> failures(count);
  std::mutex progress;
  int done = 0;
  const Execution alone{.stop = execution.stop, .num_threads = 1, .report_progress = {}};
  const bool finished = ParallelFor(execution, count, [&](int view) {
    const auto written = WriteView(studio, view, options, folder, alone);
    if (!written) failures[view] = written.error();
    const std::lock_guard lock(progress);
    execution.Report(static_cast<double>(++done) / count);
  });
  if (!finished) return Cancelled("rendering");
  for (const auto& failure : failures) {
    if (failure) return Fail(*failure);
  }
  return {};
}

Result<void> CheckRange(std::string_view option, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return Fail(ErrorCode::kBadInput, "the simulated studio: {} is {}, must lie within {} .. {}", option, value, low,
              high);
}

Result<void> Check(const FolderOptions& options) {
  if (auto checked = CheckRange("samples", options.samples_per_side, 1, kMaxSamplesPerSide); !checked) return checked;
  if (auto checked = CheckRange("blur-px", options.sensor.blur_sigma_px, 0, kMaxBlur_px); !checked) return checked;
  if (auto checked = CheckRange("noise", options.sensor.noise_sigma, 0, kMaxNoise); !checked) return checked;
  if (options.sensor.bits != 8 && options.sensor.bits != 16) {
    return Fail(ErrorCode::kBadInput, "the simulated studio: bits is {}, must be 8 or 16", options.sensor.bits);
  }
  for (const double px : options.disturb_px) {
    if (auto checked = CheckRange("disturb-px", px, 0.01, kMaxDisturbance_px); !checked) return checked;
  }
  return {};
}

Result<void> WriteCameras(const Studio& studio, const FolderOptions& options, const fs::path& folder) {
  const std::vector<VisiblePoint> points = SurfacePoints(studio, options.num_points, kMinViewsOfPoint);
  if (points.empty() && !options.disturb_px.empty()) {
    return Fail(ErrorCode::kBadInput,
                "the simulated studio: no surface point is seen by {} views or more, disturbed starts need some",
                kMinViewsOfPoint);
  }
  if (auto written = WriteWhole(folder / "points.txt", PointsText(points)); !written) return written;
  for (std::size_t i = 0; i < options.disturb_px.size(); ++i) {
    const DisturbOptions disturb{.mean_px = options.disturb_px[i],
                                 .shared_intrinsics = true,
                                 .random_seed = DeriveSeed(studio.options.random_seed, kDisturbTask + i)};
    const std::string text = MiddleburyText(Disturb(studio.truth, points, disturb));
    const std::string name = fmt::format("start_{:g}px_par.txt", options.disturb_px[i]);
    if (auto written = WriteWhole(folder / name, text); !written) return written;
  }
  if (auto written = WriteWhole(folder / "truth_par.txt", MiddleburyText(studio.truth)); !written) return written;
  return WriteWhole(folder / "truth.json", TruthJson(studio, options).dump(2) + "\n");
}

/// Largest difference between the cameras of truth.json and of the studio made from its options.
double LargestDifference(const RigCalibration& truth, const nlohmann::json& json) {
  double largest = 0;
  const auto& views = json.at("views");
  if (views.size() != truth.views.size()) return 1;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto& pose = views[i].at("cam_from_world");
    for (int axis = 0; axis < 3; ++axis) {
      const double translation = pose.at("translation_m").at(axis).get<double>();
      const double rotation = pose.at("rotation_wxyz").at(axis + 1).get<double>();
      largest = std::max(largest, std::abs(translation - truth.views[i].cam_from_world.translation[axis]));
      largest = std::max(largest, std::abs(rotation - truth.views[i].cam_from_world.rotation.vec()[axis]));
    }
  }
  return largest;
}

}  // namespace

Result<void> WriteImageFolder(const Studio& studio, const FolderOptions& options, const fs::path& folder,
                              const Execution& execution) {
  if (auto checked = Check(options); !checked) return checked;
  if (auto made = MakeFolder(folder / "masks"); !made) return made;
  if (auto written = WriteCameras(studio, options, folder); !written) return written;
  return WriteViews(studio, options, folder, execution);
}

Result<Studio> ReadStudio(const fs::path& folder, const Execution& execution) {
  const fs::path file = folder / "truth.json";
  std::ifstream stream(file);
  if (!stream) return Fail(ErrorCode::kNotFound, "{}: cannot be opened", file.string());
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  if (json.is_discarded()) return Fail(ErrorCode::kBadInput, "{}: is not JSON", file.string());
  const auto options = StudioOptionsFromJson(json);
  if (!options) return Fail(options.error().code, "{}: {}", file.string(), options.error().message);
  auto studio = MakeStudio(*options, execution);
  if (!studio) return Fail(studio.error());
  constexpr double kSamePlace = 1e-6;  // metres and quaternion components
  try {
    const double difference = LargestDifference(studio->truth, json);
    if (difference > kSamePlace) {
      return Fail(ErrorCode::kBadInput, "{}: its cameras differ by {} (limit {}) from those of this version's studio",
                  file.string(), difference, kSamePlace);
    }
  } catch (const nlohmann::json::exception& error) {
    return Fail(ErrorCode::kBadInput, "{}: {}", file.string(), error.what());
  }
  return studio;
}

}  // namespace rigcal::sim
