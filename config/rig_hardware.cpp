#include "config/rig_hardware.h"

#include <arpa/inet.h>

#include <algorithm>

#include "config/rig_axes.h"
#include "core/base/socket_address.h"

namespace rigcal {
namespace {

/// What the driver needs as its address; empty: none.
std::string_view AddressOf(const std::string& driver) {
  if (driver == "linuxcnc") return "HOST:PORT of linuxcncrsh";
  if (driver == "grbl") return "a serial device";
  if (driver == "arm") return "HOST:PORT to listen on, or a file of poses";
  return "";
}

Result<void> CheckDriver(const CheckedTable& table, const PositionerSettings& device, PositionerKind kind) {
  const bool arm = kind == PositionerKind::kArm;
  const std::string& driver = device.driver;
  const bool moves_axes = driver == "linuxcnc" || driver == "grbl";
  if (arm ? moves_axes : driver == "arm")
    return Fail(ErrorCode::kBadInput, "{} = \"{}\" does not move {}", table.Place("driver"), driver,
                arm ? "an arm" : "the axes of a turntable or gantry");
  const std::string_view needed = AddressOf(driver);
  if (!needed.empty() && device.address.empty())
    return Fail(ErrorCode::kBadInput, "{} = \"{}\": positioner.address is missing, {}", table.Place("driver"), driver,
                needed);
  if (driver == "linuxcnc" && !ParseSocketAddress(device.address, 1))
    return Fail(ErrorCode::kBadInput, "{} = \"{}\" must be {}, the port from 1 to {}", table.Place("address"),
                device.address, needed, kMostPort);
  return {};
}

Result<void> CheckCamera(const CheckedTable& table, const CameraSettings& camera, double picture_s) {
  const bool genicam = camera.driver == "genicam";
  if (genicam && camera.serial.empty() && camera.address.empty())
    return Fail(ErrorCode::kBadInput, "{}: camera '{}' has neither serial nor address, by which it would be found",
                table.Place("id"), camera.id);
  in_addr parsed{};
  if (genicam && !camera.address.empty() && inet_pton(AF_INET, camera.address.c_str(), &parsed) != 1)
    return Fail(ErrorCode::kBadInput, "{} = \"{}\" of camera '{}' must be an IPv4 address like 192.168.1.20",
                table.Place("address"), camera.address, camera.id);
  if (camera.region && (camera.region->width_px == 0 || camera.region->height_px == 0))
    return Fail(ErrorCode::kBadInput, "{} of camera '{}' is empty: [left, top, width, height]",
                table.Place("region_px"), camera.id);
  constexpr double kMicrosecondsPerSecond = 1e6;
  if (camera.exposure_us && *camera.exposure_us >= picture_s * kMicrosecondsPerSecond)
    return Fail(ErrorCode::kBadInput, "{} = {} of camera '{}' is not below capture.picture_s = {} seconds",
                table.Place("exposure_us"), *camera.exposure_us, camera.id, picture_s);
  return {};
}

CameraSettings CameraFrom(const CheckedTable& table) {
  CameraSettings camera;
  table.Read("id", camera.id);
  table.Read("driver", camera.driver);
  table.Read("serial", camera.serial);
  table.Read("address", camera.address);
  table.Read("pixel_format", camera.pixel_format);
  std::string trigger;
  table.Read("trigger", trigger);
  if (trigger == "hardware") camera.trigger = CameraTrigger::kHardware;
  table.Read("exposure_us", camera.exposure_us);
  table.Read("gain_db", camera.gain_db);
  table.Read("packet_bytes", camera.packet_bytes);
  std::vector<double> region;
  table.Read("region_px", region);
  const auto px = [&](int i) { return static_cast<int>(region[i]); };
  if (!region.empty()) camera.region = SensorRegion{px(0), px(1), px(2), px(3)};
  table.Read("lens", camera.lens);
  table.Read("focus_m", camera.focus_m);
  return camera;
}

/// Two cameras with one value of a key.
Result<void> CheckDifferent(const std::vector<CheckedTable>& tables, const std::vector<CameraSettings>& cameras,
                            const char* key, std::string CameraSettings::*member) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string& value = cameras[i].*member;
    const auto end = cameras.begin() + static_cast<std::ptrdiff_t>(i);
    const auto other = value.empty() ? end : std::find_if(cameras.begin(), end, [&](const CameraSettings& before) {
      return before.*member == value;
    });
    if (other == end) continue;
    return Fail(ErrorCode::kBadInput, "{} = \"{}\" of camera '{}' is that of camera '{}' (line {}) too",
                tables[i].Place(key), value, cameras[i].id, other->id, tables[other - cameras.begin()].Line());
  }
  return {};
}

bool Uses(const std::string& driver, const PositionerSettings& positioner, const std::vector<CameraSettings>& cameras) {
  return positioner.driver == driver || std::ranges::count(cameras, driver, &CameraSettings::driver) > 0;
}

}  // namespace

Result<PositionerSettings> ReadPositionerDevice(const CheckedTable& positioner, const std::vector<CheckedTable>& axes,
                                                PositionerKind kind) {
  PositionerSettings device;
  positioner.Read("driver", device.driver);
  positioner.Read("address", device.address);
  if (auto checked = CheckDriver(positioner, device, kind); !checked) return Fail(checked.error());
  if (device.driver == "arm" && !ParseSocketAddress(device.address, kAnyPort))
    device.address = BesideRigFile(positioner.File(), device.address).string();
  Result<std::vector<AxisSettings>> read = ReadAxes(positioner, axes, kind, device.driver);
  if (!read) return Fail(read.error());
  device.axes = std::move(*read);
  positioner.Read("settle_s", device.settle_s);
  positioner.Read("move_timeout_s", device.move_timeout_s);
  positioner.Read("tolerance_deg", device.position_tolerance_rad);
  positioner.Read("tolerance_m", device.position_tolerance_m);
  return device;
}

Result<std::vector<CameraSettings>> ReadCameras(const std::vector<CheckedTable>& tables, double picture_s) {
  std::vector<CameraSettings> cameras;
  for (const CheckedTable& table : tables) {
    cameras.push_back(CameraFrom(table));
    if (auto checked = CheckCamera(table, cameras.back(), picture_s); !checked) return Fail(checked.error());
  }
  if (auto ids = CheckDifferent(tables, cameras, "id", &CameraSettings::id); !ids) return Fail(ids.error());
  if (auto serials = CheckDifferent(tables, cameras, "serial", &CameraSettings::serial); !serials)
    return Fail(serials.error());
  if (auto addresses = CheckDifferent(tables, cameras, "address", &CameraSettings::address); !addresses)
    return Fail(addresses.error());
  return cameras;
}

CaptureSettings ReadCapture(const std::optional<CheckedTable>& table) {
  CaptureSettings capture;
  if (!table) return capture;
  table->Read("picture_s", capture.picture_s);
  table->Read("recover_s", capture.recover_s);
  table->Read("retakes", capture.retakes);
  table->Read("max_saturated", capture.max_saturated);
  table->Read("min_brightness", capture.min_brightness);
  table->Read("min_sharpness", capture.min_sharpness);
  table->Read("refuse_identical", capture.refuse_identical);
  return capture;
}

KeepRule ReadKeep(const std::optional<CheckedTable>& table) {
  KeepRule keep;
  if (!table) return keep;
  table->Read("max_age_days", keep.max_age_days);
  table->Read("max_count", keep.max_count);
  table->Read("min_free_gb", keep.min_free_bytes);
  return keep;
}

Result<std::optional<SimSettings>> ReadSim(const std::optional<CheckedTable>& table,
                                           const PositionerSettings& positioner, std::vector<CameraSettings>& cameras) {
  if (!table && !Uses("sim", positioner, cameras)) return std::optional<SimSettings>();
  SimSettings sim;
  const int num_listed = static_cast<int>(std::ranges::count(cameras, "sim", &CameraSettings::driver));
  if (num_listed > 0) sim.num_cameras = num_listed;
  if (table) {
    table->Read("scene", sim.scene);
    table->Read("surroundings", sim.surroundings);
    table->Read("num_cameras", sim.num_cameras);
    table->Read("width_px", sim.width_px);
    table->Read("height_px", sim.height_px);
    table->Read("step_error_deg", sim.step_error_rad);
    table->Read("wobble_deg", sim.wobble_rad);
    table->Read("run_out_m", sim.run_out_m);
    table->Read("blur_sigma_px", sim.blur_sigma_px);
    table->Read("noise_sigma", sim.noise_sigma);
    table->Read("random_seed", sim.random_seed);
  }
  if (num_listed > 0 && sim.num_cameras != num_listed)
    return Fail(ErrorCode::kBadInput, "{} = {}, but {} [[camera]] have the driver sim", table->Place("num_cameras"),
                sim.num_cameras, num_listed);
  if (table && cameras.empty())
    for (int c = 0; c < sim.num_cameras; ++c) cameras.push_back({.id = fmt::format("cam{}", c), .driver = "sim"});
  return std::optional(sim);
}

Result<std::optional<ReplaySettings>> ReadReplay(const std::optional<CheckedTable>& table, const std::string& file,
                                                 const PositionerSettings& positioner,
                                                 const std::vector<CameraSettings>& cameras) {
  if (!table && Uses("replay", positioner, cameras))
    return Fail(ErrorCode::kBadInput, "{}: a device has the driver replay: replay.recording is missing, a folder",
                file);
  if (!table) return std::optional<ReplaySettings>();
  ReplaySettings replay;
  table->Read("recording", replay.recording);
  replay.recording = BesideRigFile(file, replay.recording).string();
  table->Read("at_recorded_speed", replay.at_recorded_speed);
  return std::optional(replay);
}

std::filesystem::path BesideRigFile(const std::string& file, const std::string& path) {
  return std::filesystem::path(file).parent_path() / path;
}

}  // namespace rigcal
