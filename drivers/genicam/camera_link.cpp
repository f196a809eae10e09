#include "drivers/genicam/camera_link.h"

#include <utility>

#include "drivers/genicam/gige_link.h"
#include "drivers/genicam/usb_link.h"

namespace rigcal {
namespace {

void SetFlag(ArvDevice* /*device*/, gpointer flag) {
  **static_cast<std::shared_ptr<std::atomic<bool>>*>(flag) = true;
}

void DropFlag(gpointer flag, GClosure* /*closure*/) {
  delete static_cast<std::shared_ptr<std::atomic<bool>>*>(flag);
}

}  // namespace

Result<std::unique_ptr<CameraLink>> CameraLink::Open(const CameraSettings& settings, const GenicamOptions& options,
                                                     Clock& clock, const std::stop_token& stop) {
  if (UsbLink::Means(settings)) return UsbLink::Open(settings);
  return GigeLink::Open(settings, options, clock, stop);
}

CameraLink::CameraLink(const std::string& id, AnnouncedCamera announced, GObjectPointer<ArvCamera> camera)
    : id_(id),
      announced_(std::move(announced)),
      camera_(std::move(camera)),
      control_lost_(std::make_shared<std::atomic<bool>>(false)) {
  auto flag = std::make_unique<std::shared_ptr<std::atomic<bool>>>(control_lost_);
  handler_ = g_signal_connect_data(arv_camera_get_device(camera_.get()), "control-lost", G_CALLBACK(SetFlag),
                                   flag.release(), DropFlag, GConnectFlags{});
}

CameraLink::~CameraLink() {
  g_signal_handler_disconnect(arv_camera_get_device(camera_.get()), handler_);
}

}  // namespace rigcal
