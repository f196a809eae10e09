#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "config/export.h"
#include "config/load_cameras.h"
#include "daemon/cli/run_request.h"

namespace rigcal {
namespace {

struct ExportArguments {
  std::string calibration, format, out;
  bool undistorted = false;
};

int RunExport(const ExportArguments& arguments) {
  const Result<LoadedCameras> cameras = LoadCamerasUnchanged(arguments.calibration);
  if (!cameras) return FailWith("export", cameras.error());
  const ExportOptions options{*ExportFormatFromName(arguments.format), arguments.undistorted};
  std::error_code error;
  if (std::filesystem::equivalent(arguments.calibration, arguments.out, error)) {
    return FailWith("export", {ErrorCode::kBadInput, arguments.out + ": is the calibration itself and is kept"});
  }
  const auto notes = Export(cameras->calibration, options, arguments.out);
  if (!notes) return FailWith("export", notes.error());
  for (const std::string& note : *notes) fmt::print(stderr, "rigcal export: note: {}\n", note);
  return kExitAccepted;
}

}  // namespace

void AddExportCommand(CLI::App& app, CommandSession& session) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Writes a calibration for another program");
  command->add_option("CALIBRATION", arguments->calibration, "calibration.json, or any other camera file")->required();
  command->add_option("--format", arguments->format, "Format to write")
      ->required()
      ->check(CLI::IsMember({"middlebury", "colmap", "pmvs", "opencv"}));
  command->add_option("--out", arguments->out, "File (middlebury, opencv) or folder (colmap, pmvs) to write")
      ->required();
  command->add_flag("--undistorted", arguments->undistorted,
                    "Write the cameras of undistorted images: the same without distortion");
  command->callback([arguments, &session] { session.exit_status = RunExport(*arguments); });
}

}  // namespace rigcal
