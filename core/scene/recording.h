#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/rigid3.h"

namespace rigcal {

enum class Subject { kChart, kObject, kBoth };

/// A physical camera as the recording knows it; everything but the id and the size may be unknown (empty).
struct RecordedCamera {
  std::string id;
  int width_px = 0, height_px = 0;
  std::string serial, model, lens, pixel_format;
  std::optional<double> focus_m, temperature_celsius;
};

enum class AxisUnit { kRadian, kMetre };

/// The axis of a plain turntable, in recordings that are not made by devices with axis names of their own.
inline constexpr const char* kTableAxis = "table";

/// Where the positioner stood: as commanded, and as it reported afterwards. A turntable or gantry axis has named axis
/// values; an arm has a pose.
struct AxisPosition {
  std::string axis;
  AxisUnit unit = AxisUnit::kRadian;
  double commanded = 0;
  std::optional<double> reported;
};

struct RecordedStop {
  std::string id;
  std::vector<AxisPosition> axes;
  std::optional<Rigid3d> base_from_flange_commanded, base_from_flange_reported;
};

/// One picture. Without a stop (a board held by hand) it is a view with a pose of its own.
struct RecordedView {
  std::string file;  ///< relative to the recording's folder
  int camera = 0;    ///< index into Recording::cameras
  std::optional<int> stop;
  Subject subject = Subject::kObject;
  std::string sha256;
  std::optional<double> exposure_us, gain_db;
  std::optional<std::string> taken_at;  ///< ISO 8601, UTC
};

/// The one form in which pictures exist: a folder with recording.json and images. Immutable once closed.
struct Recording {
  std::string id;
  bool closed = false;
  bool linear = false;  ///< pixel values proportional to light; otherwise gamma-encoded (sRGB)
  std::vector<RecordedCamera> cameras;
  std::vector<RecordedStop> stops;
  std::vector<RecordedView> views;
};

}  // namespace rigcal
