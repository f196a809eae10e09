#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/rig_reader.h"
#include "core/scene/rig_devices.h"
#include "core/scene/rig_model.h"

namespace rigcal {

/// [positioner] as a device. Errors: kBadInput: those of ReadAxes; a driver that cannot move this kind, or without the
/// address that it needs.
Result<PositionerSettings> ReadPositionerDevice(const CheckedTable& positioner, const std::vector<CheckedTable>& axes,
                                                PositionerKind kind);

/// Every [[camera]]. Errors: kBadInput: two with one id, serial or address; a genicam camera without either, or with an
/// address that is none; an empty region; an exposure that a picture may not take (`picture_s`).
Result<std::vector<CameraSettings>> ReadCameras(const std::vector<CheckedTable>& tables, double picture_s);

/// [capture] without the stops.
CaptureSettings ReadCapture(const std::optional<CheckedTable>& table);
KeepRule ReadKeep(const std::optional<CheckedTable>& table);

/// [sim]; without the table its defaults, where a device has the driver sim. A rig with [sim] and no camera at all gets
/// those of the studio. Errors: kBadInput: another number of cameras than the rig has of the driver sim.
Result<std::optional<SimSettings>> ReadSim(const std::optional<CheckedTable>& table,
                                           const PositionerSettings& positioner, std::vector<CameraSettings>& cameras);

/// [replay]. Errors: kBadInput: a device has the driver replay and there is no [replay].
Result<std::optional<ReplaySettings>> ReadReplay(const std::optional<CheckedTable>& table, const std::string& file,
                                                 const PositionerSettings& positioner,
                                                 const std::vector<CameraSettings>& cameras);

/// A path of the rig file, which is relative to its folder.
std::filesystem::path BesideRigFile(const std::string& file, const std::string& path);

}  // namespace rigcal
