#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "sim_fixtures/u3v/usbfs_node.h"

namespace rigcal::sim {

/// How a device shows itself before anybody opens it.
struct UsbPlug {
  std::string port_path = "1-1";  ///< hubs on the way to it are plugged in too
  int speed_mbit_per_s = 5000;
  std::string vendor, model, serial;
  Bytes descriptors;
};

/// USB for this program and the programs that it starts, emulated by umockdev: it has to run under `umockdev-wrapper`.
/// One for each program: Aravis and libusb look at the first one for ever. Used by one thread.
class UsbTestbed {
 public:
  /// Errors: kUnsupported (not under umockdev-wrapper).
  static Result<std::unique_ptr<UsbTestbed>> Start();
  ~UsbTestbed();
  UsbTestbed(const UsbTestbed&) = delete;
  UsbTestbed& operator=(const UsbTestbed&) = delete;

  /// Plugs a device in and powers it on. Errors: kIo (umockdev's).
  Result<void> Plug(const UsbPlug& plug, const std::shared_ptr<UsbFunction>& function);
  /// Pulls it out again; nothing happens when there is none at the port.
  void Unplug(const std::string& port_path);
  void UnplugAll();  ///< hubs too, but for the root hubs

 private:
  struct Plugged {
    std::string folder, node_path;
    std::shared_ptr<UsbfsNode> node;
  };

  explicit UsbTestbed(GObjectPointer<UMockdevTestbed> testbed) : testbed_(std::move(testbed)) {}
  Result<void> AddHub(const std::string& port_path);
  Result<void> Add(const std::string& description);
  void Remove(const std::string& folder);

  GObjectPointer<UMockdevTestbed> testbed_;
  std::map<std::string, std::string> hubs_;  ///< folders by port path
  std::map<std::string, Plugged> plugged_;
  int last_device_ = 0;  ///< number on its bus; never given twice, as the kernel does for long
};

}  // namespace rigcal::sim
