#include "daemon/cli/run_options.h"

#include "daemon/cli/number_options.h"

namespace rigcal {

void AddPictureOptions(CLI::App& command, PictureSource& source) {
  CLI::Option_group* group = command.add_option_group("Pictures", "Where the pictures come from");
  group->add_option("--images", source.images, "Folder of photographs");
  CLI::Option* recording = group->add_option(
      "--recording", source.recording, "Recording (docs/recording.md): its pictures of the object, and their cameras");
  group->require_option(1);
  command
      .add_option("--camera-from-name", source.camera_from_name,
                  "Regular expression on the image's name; its first group is the physical camera")
      ->excludes(recording);
}

void AddMaskOptions(CLI::App& command, MaskRequest& request) {
  command
      .add_option("--masks", request.source,
                  "Folder of masks (same stem as the image, 128 and above is object), or auto: find silhouettes, or "
                  "none; ./auto is a folder of that name")
      ->type_name("DIR|auto|none")
      ->capture_default_str();
  command
      .add_option("--mask-from-name", request.mask_from_name,
                  "Stem of the mask from the image's stem, as in 'image_0*([0-9]+)=contour_$1'")
      ->type_name("REGEX=REPLACEMENT");
}

void AddRunOptions(CLI::App& command, RunRequest& request) {
  AddPictureOptions(command, request.pictures);
  command
      .add_option("--cameras", request.cameras, "Cameras: Middlebury *_par.txt, COLMAP text model or calibration.json")
      ->required();
  command
      .add_option("--expected-error-px", request.expected_error_px,
                  "Er: how many pixels the cameras may be off; estimated from the photographs when absent")
      ->check(NumberWithin(0.1, 31.0));
  AddMaskOptions(command, request.masks);
  command.add_option("--aspect", request.aspect, "fx / fy of every camera")->check(NumberWithin(0.5, 2.0));
  command.add_option("--aspect-sigma", request.aspect_sigma, "How sure that is (1 sigma)")
      ->check(NumberWithin(1e-6, 1.0));
  command.add_option("--random-seed", request.random_seed, "Seed of every random choice");
  AddThreadsOption(command, request.num_threads);
  command.add_flag("--json", request.json, "Print the report as JSON");
}

}  // namespace rigcal
