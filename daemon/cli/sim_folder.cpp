#include "daemon/cli/sim_folder.h"

#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "config/atomic_file.h"
#include "config/calibration_file.h"
#include "config/middlebury.h"
#include "config/recording_file.h"
#include "core/base/random.h"
#include "daemon/cli/sim_recording.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNoiseTask = 1000;       ///< DeriveSeed: + view
constexpr std::uint64_t kHandNoiseTask = 30000;  ///< DeriveSeed: + index of the hand-held view
constexpr std::uint64_t kDisturbTask = 5000;     ///< DeriveSeed: + index of the start
constexpr int kMinViewsOfPoint = 2;              ///< fewer say nothing about how cameras stand to each other
constexpr int kMaxSamplesPerSide = 8;
constexpr double kMaxBlur_px = 5, kMaxNoise = 64, kLeastDisturbance_px = 0.01, kMaxDisturbance_px = 100;

Result<void> WritePng(const fs::path& file, const cv::Mat& picture) {
  constexpr int kCompression = 1;  // noise does not shrink further, it only takes longer
  std::vector<std::uint8_t> bytes;
  try {
    cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, kCompression});
  } catch (const cv::Exception& error) {
    return Fail(ErrorCode::kIo, "{}: cannot be encoded ({})", file.string(), error.what());
  }
  return WriteFileAtomically(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

int NumHandHeld(const sim::Studio& studio) {
  return studio.chart ? static_cast<int>(studio.chart->hand_held.size()) : 0;
}

/// Pictures count from the views at stops on to those of the board in the hand.
Result<void> WritePicture(const sim::Studio& studio, int index, const sim::ShotOptions& shot, const fs::path& folder,
                          const Execution& execution) {
  const int held = index - studio.truth.NumViews();
  const auto rendered = held < 0 ? sim::RenderView(studio, index, shot.samples_per_side, execution)
                                 : sim::RenderHandHeld(studio, held, shot.samples_per_side, execution);
  if (!rendered) return Fail(rendered.error());
  const std::uint64_t task =
      held < 0 ? kNoiseTask + static_cast<std::uint64_t>(index) : kHandNoiseTask + static_cast<std::uint64_t>(held);
  const std::string& name = held < 0 ? studio.truth.views[index].name : studio.chart->hand_held[held].name;
  const cv::Mat picture = sim::Expose(rendered->radiance, shot.sensor, DeriveSeed(studio.options.random_seed, task));
  if (Result<void> written = WritePng(folder / name, picture); !written) return written;
  return WritePng(folder / "masks" / name, sim::MaskOf(*rendered));
}

/// All pictures, on the execution's threads; of several failures the first picture's is reported.
Result<void> WritePictures(const sim::Studio& studio, const sim::ShotOptions& shot, const fs::path& folder,
                           const Execution& execution) {
  const int count = studio.truth.NumViews() + NumHandHeld(studio);
  std::vector<std::optional<Error>> failures(count);
  std::mutex progress;
  int done = 0;
  const Execution alone{.stop = execution.stop, .num_threads = 1, .report_progress = {}};
  const bool finished = ParallelFor(execution, count, [&](int index) {
    const Result<void> written = WritePicture(studio, index, shot, folder, alone);
    if (!written) failures[index] = written.error();
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

Result<void> Check(const SimFolderOptions& options) {
  const sim::SensorOptions& sensor = options.shot.sensor;
  if (Result<void> ok = CheckRange("samples", options.shot.samples_per_side, 1, kMaxSamplesPerSide); !ok) return ok;
  if (Result<void> ok = CheckRange("blur-px", sensor.blur_sigma_px, 0, kMaxBlur_px); !ok) return ok;
  if (Result<void> ok = CheckRange("noise", sensor.noise_sigma, 0, kMaxNoise); !ok) return ok;
  if (sensor.bits != 8 && sensor.bits != 16) {
    return Fail(ErrorCode::kBadInput, "the simulated studio: bits is {}, must be 8 or 16", sensor.bits);
  }
  for (const double px : options.disturb_px) {
    if (Result<void> ok = CheckRange("disturb-px", px, kLeastDisturbance_px, kMaxDisturbance_px); !ok) return ok;
  }
  return {};
}

std::string PointsText(const std::vector<sim::VisiblePoint>& points) {
  std::string text;
  for (const sim::VisiblePoint& point : points) {
    text += fmt::format("{:.9g} {:.9g} {:.9g} {}", point.x_in_world.x(), point.x_in_world.y(), point.x_in_world.z(),
                        point.views.size());
    for (const int view : point.views) text += fmt::format(" {}", view);
    text += '\n';
  }
  return text;
}

/// STEM_par.txt and, when a camera has distortion, STEM_calibration.json.
Result<void> WriteCalibrationFiles(const fs::path& stem, const RigCalibration& calibration,
                                   const sim::StudioOptions& studio) {
  const auto with_suffix = [&](const char* suffix) { return fs::path(stem.string() + suffix); };
  RigCalibration pinhole = calibration;
  bool distorted = false;
  for (Camera& camera : pinhole.cameras) {
    distorted = distorted || camera.HasDistortion();
    camera = Undistorted(camera);
  }
  if (Result<void> ok = WriteFileAtomically(with_suffix("_par.txt"), MiddleburyText(pinhole)); !ok) return ok;
  if (!distorted) return {};
  Provenance provenance;
  provenance.program_version = ProgramVersion();
  provenance.method = "sim";
  provenance.options = {{"scene", std::string(sim::NameOf(studio.scene))}};
  provenance.random_seed = studio.random_seed;
  return WriteCalibration(with_suffix("_calibration.json"), calibration, provenance);
}

}  // namespace

Result<void> WriteSimStart(const sim::Studio& studio, const std::vector<sim::VisiblePoint>& points,
                           const sim::DisturbOptions& options, const fs::path& stem) {
  if (Result<void> ok = CheckRange("disturb-px", options.mean_px, kLeastDisturbance_px, kMaxDisturbance_px); !ok) {
    return ok;
  }
  if (points.empty()) {
    return Fail(ErrorCode::kBadInput,
                "the simulated studio: no surface point is seen by {} views or more, a disturbed start needs some",
                kMinViewsOfPoint);
  }
  return WriteCalibrationFiles(stem, sim::Disturb(studio.truth, points, options), studio.options);
}

Result<void> WriteSimFolder(const sim::Studio& studio, const SimFolderOptions& options, const fs::path& folder,
                            const Execution& execution) {
  if (Result<void> ok = Check(options); !ok) return ok;
  std::error_code error;
  if (fs::exists(folder / kRecordingFile, error))
    return Fail(ErrorCode::kBadInput, "{}: holds a recording, which is not written over", folder.string());
  if (Result<void> ok = PrepareOutputFolder(folder / "masks"); !ok) return ok;
  const auto points = sim::SurfacePoints(studio, options.num_points, kMinViewsOfPoint);
  if (Result<void> ok = WriteFileAtomically(folder / "points.txt", PointsText(points)); !ok) return ok;
  for (std::size_t i = 0; i < options.disturb_px.size(); ++i) {
    const sim::DisturbOptions disturb{.mean_px = options.disturb_px[i],
                                      .shared_intrinsics = true,
                                      .random_seed = DeriveSeed(studio.options.random_seed, kDisturbTask + i)};
    const fs::path stem = folder / fmt::format("start_{:g}px", disturb.mean_px);
    if (Result<void> ok = WriteSimStart(studio, points, disturb, stem); !ok) return ok;
  }
  if (Result<void> ok = WriteCalibrationFiles(folder / "truth", studio.truth, studio.options); !ok) return ok;
  if (Result<void> ok = WriteFileAtomically(folder / "truth.json", sim::TruthText(studio, options.shot)); !ok) {
    return ok;
  }
  if (Result<void> ok = WritePictures(studio, options.shot, folder, execution); !ok || !options.recording) return ok;
  return WriteSimRecording(studio, options.shot, folder);
}

}  // namespace rigcal
