#include "drivers/genicam/gige_link.h"

#include <algorithm>
#include <utility>

#include "core/base/joined.h"

namespace rigcal {
namespace {

constexpr double kHeldAgain_s = 0.2;           ///< between two looks whether a camera is free
constexpr guint64 kHeartbeatRegister = 0x938;  ///< bootstrap: the time after which a silent controller is forgotten

/// The camera that the settings mean. Errors: kNotFound, kBadInput, kDevice, kCancelled.
Result<GigeAnswer> Locate(const CameraSettings& settings, const GenicamOptions& options, Clock& clock,
                          const std::stop_token& stop) {
  const auto named = [&](const Error& error) {
    return Fail(error.code, "camera '{}': {}", settings.id, error.message);
  };
  if (settings.address.empty()) {
    const Result<std::vector<GigeAnswer>> all = FindGigeCameras(options.reach, settings.serial, clock, stop);
    if (!all) return named(all.error());
    const auto wanted = std::ranges::find(*all, settings.serial, &GigeAnswer::serial);
    if (wanted != all->end()) return *wanted;
    std::vector<std::string> others;
    for (const GigeAnswer& each : *all) others.push_back(each.serial);
    return Fail(ErrorCode::kNotFound, "camera '{}': none with the serial number '{}' answers, found: {}", settings.id,
                settings.serial, others.empty() ? "none" : Joined(others, ", "));
  }
  Result<std::optional<GigeAnswer>> answer = AskGigeCamera(settings.address, options.answer_s, clock, stop);
  if (!answer) return named(answer.error());
  if (!*answer) {
    return Fail(ErrorCode::kNotFound, "camera '{}': nothing answers at {} within {:.1f} s", settings.id,
                settings.address, options.answer_s);
  }
  if (!settings.serial.empty() && settings.serial != (*answer)->serial) {
    return Fail(ErrorCode::kNotFound, "camera '{}': at {} is the camera with the serial number '{}', not '{}'",
                settings.id, settings.address, (*answer)->serial, settings.serial);
  }
  (*answer)->address = settings.address;
  return **answer;
}

/// Waits until nobody controls it any more, for a program of this machine that is gone. Errors: kDevice: who does.
Result<void> AwaitFree(const std::string& id, const std::string& address, const std::string& own_address,
                       const GenicamOptions& options, Clock& clock, const std::stop_token& stop) {
  const double end_s = clock.NowS() + options.abandoned_s;
  while (true) {
    const Result<std::optional<GigeHolder>> holder = HolderOfGigeCamera(address, options.answer_s, clock, stop);
    if (!holder && holder.error().code == ErrorCode::kCancelled) return Fail(holder.error());
    if (!holder) return Fail(ErrorCode::kDevice, "camera '{}': {}", id, holder.error().message);
    if (!*holder) return {};
    const GigeHolder& held = **holder;
    if (held.address != own_address || clock.NowS() >= end_s) {
      return Fail(ErrorCode::kDevice, "camera '{}' at {}: is controlled by {}{}", id, address,
                  held.address.empty() ? "a program that it does not name" : held.address,
                  held.exclusive                ? ", exclusively"
                  : held.address == own_address ? ", another program on this machine"
                                                : "");
    }
    if (!clock.Wait(kHeldAgain_s, stop)) {
      return Fail(ErrorCode::kCancelled, "camera '{}': opening it was stopped on request", id);
    }
  }
}

/// Through the interface that leads there: Aravis itself would take the first one that gets an answer, and look for the
/// pictures on another than they come in by.
Result<GObjectPointer<ArvCamera>> OpenAt(const std::string& id, const std::string& address,
                                         const std::string& own_address) {
  const GObjectPointer<GInetAddress> own(g_inet_address_new_from_string(own_address.c_str()));
  const GObjectPointer<GInetAddress> there(g_inet_address_new_from_string(address.c_str()));
  GLibError error;
  const GObjectPointer<ArvDevice> device(arv_gv_device_new(own.get(), there.get(), error.Take()));
  if (!device) return Fail(ErrorCode::kDevice, "camera '{}' at {}: cannot be opened: {}", id, address, error.Text());
  if (arv_gv_device_is_controller(ARV_GV_DEVICE(device.get())) == FALSE) {
    return Fail(ErrorCode::kDevice, "camera '{}' at {}: somebody else has just taken the control of it", id, address);
  }
  GObjectPointer<ArvCamera> camera(arv_camera_new_with_device(device.get(), error.Take()));
  if (!camera) return Fail(ErrorCode::kDevice, "camera '{}' at {}: cannot be opened: {}", id, address, error.Text());
  return camera;
}

}  // namespace

Result<std::unique_ptr<CameraLink>> GigeLink::Open(const CameraSettings& settings, const GenicamOptions& options,
                                                   Clock& clock, const std::stop_token& stop) {
  Result<GigeAnswer> found = Locate(settings, options, clock, stop);
  if (!found) return Fail(found.error());
  const Result<std::string> own = OwnAddressTowards(found->address);
  if (!own) return Fail(own.error().code, "camera '{}': {}", settings.id, own.error().message);
  if (Result<void> is_free = AwaitFree(settings.id, found->address, *own, options, clock, stop); !is_free) {
    return Fail(is_free.error());
  }
  Result<GObjectPointer<ArvCamera>> camera = OpenAt(settings.id, found->address, *own);
  if (!camera) return Fail(camera.error());
  return std::unique_ptr<CameraLink>(new GigeLink(settings.id, *found, options, clock, std::move(*camera)));
}

GigeLink::GigeLink(const std::string& id, const GigeAnswer& announced, const GenicamOptions& options, Clock& clock,
                   GObjectPointer<ArvCamera> camera)
    : CameraLink(id,
                 {.address = announced.address,
                  .vendor = announced.vendor,
                  .model = announced.model,
                  .serial = announced.serial},
                 std::move(camera)),
      answer_s_(options.answer_s),
      clock_(clock) {}

bool GigeLink::Answers(const std::stop_token& stop) const {
  const Result<std::optional<GigeAnswer>> answer = AskGigeCamera(Announced().address, answer_s_, clock_, stop);
  return answer && *answer && (*answer)->serial == Announced().serial;
}

Result<void> GigeLink::Check(const std::stop_token& stop) const {
  if (!Answers(stop)) {
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "camera '{}': was stopped on request", Id());
    return Fail(ErrorCode::kDevice, "camera '{}': does not answer at {} any more", Id(), Announced().address);
  }
  // Only the controller may write; a camera that was without power has forgotten who that was.
  ArvDevice* device = arv_camera_get_device(Camera());
  GLibError error;
  guint32 heartbeat_ms = 0;
  if (arv_device_read_register(device, kHeartbeatRegister, &heartbeat_ms, error.Take()) == FALSE ||
      arv_device_write_register(device, kHeartbeatRegister, heartbeat_ms, error.Take()) == FALSE || ControlLost()) {
    return Fail(ErrorCode::kDevice, "camera '{}' at {}: the control of it is lost: {}", Id(), Announced().address,
                error.Happened() ? error.Text() : "its heartbeat stopped");
  }
  return {};
}

}  // namespace rigcal
