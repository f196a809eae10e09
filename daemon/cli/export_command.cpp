#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "config/calibration_file.h"
#include "config/export.h"
#include "config/load_cameras.h"
#include "daemon/cli/command.h"
#include "daemon/cli/store_options.h"

namespace rigcal {
namespace {

struct ExportArguments {
  std::string calibration, format, out;
  bool undistorted = false;
  StoreChoice choice;
};

Result<RigCalibration> FromFile(const std::string& file) {
  Result<LoadedCameras> cameras = LoadCamerasUnchanged(file);
  if (!cameras) return Fail(cameras.error());
  return std::move(cameras->calibration);
}

Result<RigCalibration> FromStore(const StoreChoice& choice, int number) {
  const auto opened = OpenRigStore(choice);
  if (!opened) return Fail(opened.error());
  const auto revision = opened->store->Load(opened->rig, number);
  if (!revision) return Fail(revision.error());
  auto content = ParseCalibration(revision->calibration_text, fmt::format("revision {}", number));
  if (!content) return Fail(content.error());
  return std::move(content->calibration);
}

/// What is neither a file nor a number is most likely a file that is missing.
Result<RigCalibration> Cameras(const ExportArguments& arguments) {
  const Result<int> number = RevisionNumber(arguments.calibration);
  if (NamesFile(arguments.calibration) || !number) return FromFile(arguments.calibration);
  return FromStore(arguments.choice, *number);
}

int RunExport(const ExportArguments& arguments) {
  const Result<RigCalibration> calibration = Cameras(arguments);
  if (!calibration) return FailWith("export", calibration.error());
  const ExportOptions options{*ExportFormatFromName(arguments.format), arguments.undistorted};
  std::error_code error;
  if (std::filesystem::equivalent(arguments.calibration, arguments.out, error)) {
    return FailWith("export", {ErrorCode::kBadInput, arguments.out + ": is the calibration itself and is kept"});
  }
  const auto notes = Export(*calibration, options, arguments.out);
  if (!notes) return FailWith("export", notes.error());
  for (const std::string& note : *notes) fmt::print(stderr, "rigcal export: note: {}\n", note);
  return kExitAccepted;
}

bool IsFolder(const FormatEntry& entry) {
  return entry.is_folder;
}
bool IsFile(const FormatEntry& entry) {
  return !entry.is_folder;
}

std::vector<std::string> Names(bool (*has)(const FormatEntry&)) {
  std::vector<std::string> names;
  for (const FormatEntry& entry : ExportFormats())
    if (has(entry)) names.emplace_back(entry.name);
  return names;
}

}  // namespace

void AddExportCommand(CLI::App& app, CommandSession& session) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Writes a calibration for another program");
  command
      ->add_option("CALIBRATION", arguments->calibration,
                   "calibration.json, any other camera file, or the number of a revision in the store")
      ->required();
  AddStoreOptions(*command, arguments->choice);
  command->add_option("--format", arguments->format, "Format to write (docs/formats.md)")
      ->required()
      ->check(CLI::IsMember(Names([](const FormatEntry&) { return true; })));
  command
      ->add_option("--out", arguments->out,
                   fmt::format("File ({}) or folder ({}) to write; an earlier export there is replaced",
                               fmt::join(Names(IsFile), ", "), fmt::join(Names(IsFolder), ", ")))
      ->required();
  command->add_flag(
      "--undistorted", arguments->undistorted,
      "Write the cameras of undistorted images, for formats that cannot say what the cameras have (docs/formats.md)");
  command->callback([arguments, &session] { session.exit_status = RunExport(*arguments); });
}

}  // namespace rigcal
