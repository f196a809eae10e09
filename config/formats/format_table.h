#pragma once

#include <span>
#include <string>
#include <string_view>

#include "config/formats/exported_files.h"
#include "config/formats/limits.h"
#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

enum class ExportFormat {
  kMiddlebury,
  kColmap,
  kColmapBinary,
  kPmvs,
  kOpenCv,
  kKalibr,
  kRos,
  kNerfstudio,
  kMetashape,
  kRealityCapture,
  kOpenMvg,
  kMrcal,
  kBundler
};

/// All that the program knows of one export format; the option's list, its help and the table in docs/formats.md are
/// made from these.
struct FormatEntry {
  ExportFormat format;
  std::string_view name;   ///< what --format takes
  std::string_view title;  ///< as people call it, in messages
  bool is_folder;          ///< several files in a folder; otherwise one file
  Result<ExportedFiles> (*files)(const RigCalibration& calibration);
  Gaps gaps;
  std::string_view caveat;          ///< a sentence that every user of the format should read, or empty
  std::string_view published_name;  ///< of its file in a publish folder; empty: its name
  // For docs/formats.md:
  std::string_view holds, pixel_origin, axes, verified;
};

/// In the order of ExportFormat.
std::span<const FormatEntry> ExportFormats();
const FormatEntry& EntryOf(ExportFormat format);
/// The format that the name stands for ("colmap"); null for another name.
const FormatEntry* EntryNamed(std::string_view name);

/// The rows of docs/formats.md's table of exports.
std::string FormatTableText();

}  // namespace rigcal
