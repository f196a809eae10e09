#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "config/atomic_file.h"
#include "config/patches_file.h"
#include "core/mvs/reconstruct.h"
#include "daemon/cli/command.h"
#include "daemon/cli/number_options.h"
#include "daemon/cli/progress_line.h"
#include "daemon/cli/run_options.h"

namespace rigcal {
namespace {

constexpr int kMaxLevel = 8;  // a picture of 12 megapixels is 16 pixels wide there

struct MvsArguments {
  PictureSource pictures;
  std::filesystem::path cameras, out;
  MaskRequest masks;
  StereoOptions stereo;
  double expected_error_px = 0;  ///< 0: the cameras are exact
  int num_threads = 0;           ///< 0: one for each processor
};

Result<LoadedImages> LoadPictures(const MvsArguments& arguments, const OpenedPictures& pictures,
                                  RigCalibration& calibration, RunContext& context) {
  const ImageOptions options{.num_levels = arguments.stereo.level + 1,
                             .colour_level = arguments.stereo.level,
                             .masks = arguments.masks.Source(),
                             .mask_folder = arguments.masks.Folder(),
                             .mask_from_name = arguments.masks.mask_from_name,
                             .sha256_by_image = pictures.recorded.sha256_by_image};
  return context.Time("load", -1, [&](const Execution& execution) {
    return LoadImages(pictures.folder, calibration, options, execution);
  });
}

/// The number of patches written.
Result<std::size_t> MakePatches(const MvsArguments& arguments, RunContext& context) {
  if (Result<void> checked = arguments.masks.Check(); !checked) return Fail(checked.error());
  std::error_code ignored;
  if (std::filesystem::is_directory(arguments.out, ignored)) {
    return Fail(ErrorCode::kBadInput, "{}: a file is needed here, this is a folder", arguments.out.string());
  }
  if (Result<void> ready = PrepareOutputFolder(std::filesystem::absolute(arguments.out).parent_path()); !ready)
    return Fail(ready.error());
  const Result<OpenedPictures> pictures = OpenPictures(arguments.pictures);
  if (!pictures) return Fail(pictures.error());
  Result<LoadedCameras> cameras = LoadCamerasUnchanged(arguments.cameras, pictures->naming);
  if (!cameras) return Fail(cameras.error());
  RigCalibration& calibration = cameras->calibration;
  if (Result<void> complete = CheckAllHaveCameras(pictures->recorded, calibration, arguments.cameras); !complete)
    return Fail(complete.error());
  const Result<LoadedImages> loaded = LoadPictures(arguments, *pictures, calibration, context);
  if (!loaded) return Fail(loaded.error());
  StereoOptions options = arguments.stereo;
  options.expected_error_px.assign(calibration.views.size(), arguments.expected_error_px);
  const auto patches = context.Time("stereo", -1, [&](const Execution& execution) {
    return Reconstruct(loaded->images, calibration, options, execution);
  });
  if (!patches) return Fail(patches.error());
  const auto colours = PatchColours(*patches, loaded->images, calibration);
  if (Result<void> written = WritePatches(arguments.out, *patches, colours); !written) return Fail(written.error());
  return patches->size();
}

int RunMvs(const MvsArguments& arguments, const CommandSession& session) {
  ProgressLine line(session.on_terminal, MonotonicSeconds);
  RunContext context(session.stop, NumThreads(arguments.num_threads), MonotonicSeconds,
                     [&line](const RunProgress& progress) { line.Show(progress); });
  const Result<std::size_t> num_patches = MakePatches(arguments, context);
  line.Clear();
  if (!num_patches) return FailWith("mvs", num_patches.error());
  fmt::print("{} patches\n", *num_patches);
  for (const StageTime& stage : context.Timing().stages) fmt::print("{} {:.2f} s\n", stage.stage, stage.wall_s);
  return kExitAccepted;
}

}  // namespace

void AddMvsCommand(CLI::App& app, CommandSession& session) {
  auto arguments = std::make_shared<MvsArguments>();
  CLI::App* command = app.add_subcommand("mvs", "Patches on the object's surface by multi-view stereo");
  AddPictureOptions(*command, arguments->pictures);
  command->add_option("--cameras", arguments->cameras, "Camera file, see docs/formats.md")->required();
  command->add_option("--level", arguments->stereo.level, "Pyramid level, 0 is full size")
      ->required()
      ->check(CLI::Range(0, kMaxLevel));
  command->add_option("--out", arguments->out, "patches.ply to write")->required();
  AddMaskOptions(*command, arguments->masks);
  AddThreadsOption(*command, arguments->num_threads);
  command->add_option("--cell", arguments->stereo.cell_px, "One patch per cell of so many pixels of the level")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  command->add_option("--window", arguments->stereo.window_px, "Side of the correlation window, pixels of the level")
      ->check(CLI::IsMember({3, 5, 7, 9, 11, 13, 15}))
      ->capture_default_str();
  command->add_option("--min-views", arguments->stereo.min_views, "Least number of views of a patch")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
  command
      ->add_option("--expected-error-px", arguments->expected_error_px,
                   "How many full-size pixels the cameras may be off; 0: they are exact")
      ->check(NumberWithin(0, 31))
      ->capture_default_str();
  command->callback([arguments, &session] { session.exit_status = RunMvs(*arguments, session); });
}

}  // namespace rigcal
