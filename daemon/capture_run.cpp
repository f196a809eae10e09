#include "daemon/capture_run.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <utility>

#include "config/recording_file.h"
#include "core/base/ensure.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// Of a pixel as it is stored: grey or, from a Bayer pattern, three channels; 8 or 16 bits.
std::uintmax_t BytesPerPixel(const std::string& pixel_format) {
  const bool deep = pixel_format.find("10") != std::string::npos || pixel_format.find("12") != std::string::npos ||
                    pixel_format.find("16") != std::string::npos;
  return (pixel_format.starts_with("Mono") ? 1u : 3u) * (deep ? 2u : 1u);
}

Result<std::uintmax_t> FreeBytes(const fs::path& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder, error);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  const fs::space_info space = fs::space(there, error);
  if (error) return Fail(ErrorCode::kIo, "{}: its free space cannot be told ({})", folder.string(), error.message());
  return space.available;
}

Result<void> CheckSpace(const AcquisitionDevices& devices, const AcquisitionPlan& plan, const CaptureRequest& request) {
  const std::uintmax_t needed = BytesNeeded(devices, plan) + kReserve_bytes;
  const Result<std::uintmax_t> free = request.free_bytes ? request.free_bytes(request.out) : FreeBytes(request.out);
  if (!free) return Fail(free.error());
  if (*free >= needed) return {};
  std::size_t num_pictures = 0;
  for (const PlannedStop& stop : plan.stops) num_pictures += stop.cameras.size();
  return Fail(ErrorCode::kDiskFull, "{}: {} bytes are free, {} pictures need {}", request.out.string(), *free,
              num_pictures, needed);
}

/// A name of a file from ids that may hold anything: none that the recording has.
std::string FileName(const std::string& camera, const std::string& stop, const Recording& recording) {
  std::string name = camera + "_" + stop;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-' && c != '.') c = '_';
  }
  std::string file = name + ".png";
  // Camera "left" at stop "x_1" and camera "left_x" at stop "1".
  for (int number = 2; std::ranges::find(recording.views, file, &RecordedView::file) != recording.views.end();
       ++number) {
    file = fmt::format("{}~{}.png", name, number);
  }
  return file;
}

Result<std::string> PngOf(const cv::Mat& pixels, const std::string& file) {
  constexpr int kCompression = 1;  // noise does not shrink further, it only takes longer
  std::vector<std::uint8_t> bytes;
  try {
    cv::imencode(".png", pixels, bytes, {cv::IMWRITE_PNG_COMPRESSION, kCompression});
  } catch (const cv::Exception& error) {
    return Fail(ErrorCode::kIo, "{}: cannot be encoded ({})", file, error.what());
  }
  return std::string(bytes.begin(), bytes.end());
}

bool SameCamera(const RecordedCamera& a, const RecordedCamera& b) {
  return a.id == b.id && a.serial == b.serial && a.width_px == b.width_px && a.height_px == b.height_px &&
         a.pixel_format == b.pixel_format;
}

/// The devices' cameras are the recording's: added to a new one, compared with one that goes on.
Result<void> MatchCameras(const AcquisitionDevices& devices, RecordingWriter& writer, const fs::path& out) {
  for (std::size_t c = 0; c < devices.cameras.size(); ++c) {
    const RecordedCamera& camera = devices.cameras[c]->Identity();
    const std::vector<RecordedCamera>& recorded = writer.Content().cameras;
    if (c == recorded.size()) {
      if (const Result<int> added = writer.AddCamera(camera); !added) return Fail(added.error());
    } else if (!SameCamera(camera, recorded[c])) {
      return Fail(ErrorCode::kBadInput, "{}: camera '{}' of the recording is not the rig's '{}': {} x {} px {}",
                  out.string(), recorded[c].id, camera.id, camera.width_px, camera.height_px, camera.pixel_format);
    }
  }
  if (writer.Content().cameras.size() == devices.cameras.size()) return {};
  return Fail(ErrorCode::kBadInput, "{}: the recording has {} cameras, the rig {}", out.string(),
              writer.Content().cameras.size(), devices.cameras.size());
}

std::optional<int> StopIndex(const Recording& recording, const std::string& id) {
  const auto stop = std::ranges::find(recording.stops, id, &RecordedStop::id);
  if (stop == recording.stops.end()) return std::nullopt;
  return static_cast<int>(stop - recording.stops.begin());
}

/// The cameras whose picture of the stop the recording lacks.
std::vector<int> MissingAt(const std::string& stop_id, std::vector<int> cameras, const Recording& recording,
                           Subject subject) {
  const std::optional<int> stop = StopIndex(recording, stop_id);
  std::erase_if(cameras, [&](int camera) {
    return stop && std::ranges::any_of(recording.views, [&](const RecordedView& view) {
             return view.camera == camera && view.stop == stop && view.subject == subject;
           });
  });
  return cameras;
}

/// An arm that comes to a stop of the recording again is where it was.
Result<void> CheckSamePlace(const RecordedStop& reached, const Recording& recording, const CaptureRequest& request) {
  const std::optional<int> stop = StopIndex(recording, reached.id);
  if (!stop || !reached.base_from_flange_commanded) return {};
  const std::optional<Rigid3d>& before = recording.stops[*stop].base_from_flange_commanded;
  if (!before) {
    return Fail(ErrorCode::kBadInput, "{}: stop '{}' of the recording is not an arm's", request.out.string(),
                reached.id);
  }
  const Rigid3d moved = before->Inverse() * *reached.base_from_flange_commanded;
  const double turned_rad = LogRotation(moved.rotation).norm(), shifted_m = moved.translation.norm();
  if (turned_rad <= request.same_place_rad && shifted_m <= request.same_place_m) return {};
  return Fail(
      ErrorCode::kBadInput,
      "{}: stop '{}' of the recording is {:.6f} m and {:.6f} rad from where the arm is now, {:.6f} m and {:.6f} "
      "rad are allowed",
      request.out.string(), reached.id, shifted_m, turned_rad, request.same_place_m, request.same_place_rad);
}

/// Two commanded values, rad or m, are one within this: far below what a positioner resolves, far above what degrees
/// and decimal digits round.
constexpr double kSameCommand = 1e-9;

std::string PlaceText(const std::vector<double>& axes) {
  std::vector<std::string> values;
  for (const double value : axes) values.push_back(fmt::format("{:.6g}", value));
  return fmt::format("[{}]", Joined(values, ", "));
}

/// The stops that a recording has are those that are asked for: pictures of one stop are of one place, and none that
/// lacks a picture is left out.
Result<void> CheckStopsOfPlan(const Recording& recording, const CaptureRequest& request) {
  for (const RecordedStop& recorded : recording.stops) {
    const auto planned = std::ranges::find_if(request.plan.stops,
                                              [&](const PlannedStop& stop) { return stop.target.id == recorded.id; });
    if (planned == request.plan.stops.end()) {
      return Fail(ErrorCode::kBadInput, "{}: stop '{}' of the recording is none of those that are asked for",
                  request.out.string(), recorded.id);
    }
    std::vector<double> before;
    for (const AxisPosition& axis : recorded.axes) before.push_back(axis.commanded);
    const auto same = [](double a, double b) { return std::abs(a - b) <= kSameCommand; };
    if (std::ranges::equal(before, planned->target.axes, same)) continue;
    return Fail(ErrorCode::kBadInput, "{}: stop '{}' of the recording is at {} (rad or m), not at {}",
                request.out.string(), recorded.id, PlaceText(before), PlaceText(planned->target.axes));
  }
  return {};
}

/// What goes on is the recording that was begun: its kind of pictures, its subject, its stops.
Result<void> CheckSameRecording(const RecordingWriter& writer, bool linear, const CaptureRequest& request) {
  if (writer.Content().linear != linear) {
    return Fail(ErrorCode::kBadInput, "{}: the recording's pictures are {}, the rig's cameras give {} ones",
                request.out.string(), linear ? "gamma-encoded" : "linear", linear ? "linear" : "gamma-encoded");
  }
  for (const RecordedView& view : writer.Content().views) {
    if (view.subject == request.subject) continue;
    return Fail(ErrorCode::kBadInput, "{}: view '{}' of the recording shows the {}, not the {}", request.out.string(),
                view.file, NameOf(view.subject), NameOf(request.subject));
  }
  return request.plan.cameras_at ? Result<void>() : CheckStopsOfPlan(writer.Content(), request);
}

/// The plan without what the recording has; stops without anything left are not visited.
AcquisitionPlan Missing(AcquisitionPlan plan, const AcquisitionDevices& devices, const Recording& recording,
                        const CaptureRequest& request) {
  if (plan.cameras_at) {
    // The recording as it is now: it grows while pictures are taken.
    plan.cameras_at = [&devices, &request, recording](const RecordedStop& reached) -> Result<std::vector<int>> {
      if (Result<void> same = CheckSamePlace(reached, recording, request); !same) return Fail(same.error());
      const Result<std::vector<int>> wanted = request.plan.cameras_at(reached);
      if (!wanted) return Fail(wanted.error());
      std::vector<int> missing = MissingAt(reached.id, *wanted, recording, request.subject);
      const AcquisitionPlan here{.stops = {{{reached.id, {}}, missing}}};
      if (Result<void> room = CheckSpace(devices, here, request); !room) return Fail(room.error());
      return missing;
    };
  }
  for (PlannedStop& planned : plan.stops) {
    planned.cameras = MissingAt(planned.target.id, std::move(planned.cameras), recording, request.subject);
  }
  std::erase_if(plan.stops, [](const PlannedStop& planned) { return planned.cameras.empty(); });
  return plan;
}

Result<bool> LinearOf(const AcquisitionDevices& devices) {
  const bool linear = devices.cameras.front()->Linear();
  for (const CameraDevice* camera : devices.cameras) {
    if (camera->Linear() != linear) {
      return Fail(ErrorCode::kBadInput, "camera '{}': its gamma is {}, that of '{}' is not; a recording has one kind",
                  camera->Identity().id, linear ? "on" : "off", devices.cameras.front()->Identity().id);
    }
  }
  return linear;
}

/// Puts taken pictures into the recording.
class RecordingSink {
 public:
  RecordingSink(RecordingWriter& writer, const CaptureRequest& request) : writer_(writer), request_(request) {}

  Result<void> Store(const TakenPicture& taken) {
    std::optional<int> stop = StopIndex(writer_.Content(), taken.stop.id);
    if (!stop) {
      const Result<int> added = writer_.AddStop(taken.stop);
      if (!added) return Fail(added.error());
      stop = *added;
    }
    const CapturedPicture& picture = taken.picture;
    RecordedView view{.camera = taken.camera,
                      .stop = stop,
                      .subject = request_.subject,
                      .exposure_us = picture.exposure_us,
                      .gain_db = picture.gain_db,
                      .taken_at = picture.taken_at};
    if (picture.file) {
      view.file = picture.file->name;
      return writer_.AddView(std::move(view), picture.file->bytes);
    }
    view.file = FileName(writer_.Content().cameras[taken.camera].id, taken.stop.id, writer_.Content());
    const Result<std::string> png = PngOf(picture.pixels, view.file);
    if (!png) return Fail(png.error());
    return writer_.AddView(std::move(view), *png);
  }

 private:
  RecordingWriter& writer_;
  const CaptureRequest& request_;
};

/// An arm says where it ends, not whether it came again to every stop that was interrupted.
Result<void> CheckWhole(const CaptureRequest& request, const Recording& recording) {
  if (!request.plan.cameras_at) return {};
  if (recording.stops.empty()) {
    return Fail(ErrorCode::kDevice, "{}: the positioner ended without any stop", request.out.string());
  }
  for (const RecordedStop& stop : recording.stops) {
    const Result<std::vector<int>> wanted = request.plan.cameras_at(stop);
    if (!wanted) return Fail(wanted.error());
    const std::vector<int> missing = MissingAt(stop.id, *wanted, recording, request.subject);
    if (missing.empty()) continue;
    return Fail(ErrorCode::kDevice,
                "{}: stop '{}' lacks {} of {} pictures, and the positioner did not come there again",
                request.out.string(), stop.id, missing.size(), wanted->size());
  }
  return {};
}

/// Stop by stop in the plan's order, or else as the stops came, and camera by camera.
RecordingOrder OrderOf(const AcquisitionPlan& plan, const Recording& recording) {
  RecordingOrder order;
  for (const PlannedStop& planned : plan.stops) order.stops.push_back(planned.target.id);
  if (plan.cameras_at) {
    for (const RecordedStop& stop : recording.stops) order.stops.push_back(stop.id);
  }
  for (const std::string& id : order.stops) {
    const std::optional<int> stop = StopIndex(recording, id);
    for (int camera = 0; camera < static_cast<int>(recording.cameras.size()); ++camera) {
      for (const RecordedView& view : recording.views) {
        if (stop && view.stop == stop && view.camera == camera) order.views.push_back(view.file);
      }
    }
  }
  return order;
}

}  // namespace

std::uintmax_t BytesNeeded(const AcquisitionDevices& devices, const AcquisitionPlan& plan) {
  std::uintmax_t bytes = 0;
  for (const PlannedStop& planned : plan.stops) {
    for (const int c : planned.cameras) {
      const RecordedCamera& camera = devices.cameras[c]->Identity();
      bytes += static_cast<std::uintmax_t>(camera.width_px) * static_cast<std::uintmax_t>(camera.height_px) *
               BytesPerPixel(camera.pixel_format);
    }
  }
  return bytes;
}

Result<CaptureOutcome> CaptureRecording(const AcquisitionDevices& devices, const CaptureRequest& request,
                                        const std::function<void(const AcquisitionProgress&)>& listener,
                                        const std::stop_token& stop) {
  Ensure(!devices.cameras.empty(), "a recording has cameras");
  const Result<bool> linear = LinearOf(devices);
  if (!linear) return Fail(linear.error());
  Result<void> room = request.resume ? Result<void>() : CheckSpace(devices, request.plan, request);
  if (!room) return Fail(room.error());
  Result<RecordingWriter> writer =
      request.resume ? RecordingWriter::Resume(request.out) : RecordingWriter::Create(request.out, request.id, *linear);
  if (!writer) return Fail(writer.error());
  if (Result<void> same = CheckSameRecording(*writer, *linear, request); !same) return Fail(same.error());
  if (Result<void> same = MatchCameras(devices, *writer, request.out); !same) return Fail(same.error());
  const AcquisitionPlan missing = Missing(request.plan, devices, writer->Content(), request);
  if (request.resume) room = CheckSpace(devices, missing, request);
  if (!room) return Fail(room.error());
  RecordingSink sink(*writer, request);
  const Result<AcquisitionOutcome> acquired = Acquire(
      devices, missing, [&](const TakenPicture& taken) { return sink.Store(taken); }, listener, stop);
  if (!acquired) return Fail(acquired.error());
  if (Result<void> whole = CheckWhole(request, writer->Content()); !whole) return Fail(whole.error());
  const bool own_order = request.order.views.empty();
  const RecordingOrder order = own_order ? OrderOf(request.plan, writer->Content()) : request.order;
  if (Result<void> closed = writer->Close(order); !closed) return Fail(closed.error());
  return CaptureOutcome{*acquired, writer->Content()};
}

}  // namespace rigcal
