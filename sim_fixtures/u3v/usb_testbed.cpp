#include "sim_fixtures/u3v/usb_testbed.h"

#include <fmt/format.h>

#include "sim_fixtures/u3v/u3v_descriptors.h"

namespace rigcal::sim {
namespace {

constexpr const char* kController = "/devices/pci0000:00/0000:00:14.0";

std::string BusOf(const std::string& port_path) {
  return port_path.substr(0, port_path.find('-'));
}

/// The hub that a device hangs on: "1-2" of "1-2.3", the root hub "usb1" of "1-2".
std::string HubOf(const std::string& port_path) {
  const std::size_t dot = port_path.rfind('.');
  return dot == std::string::npos ? "usb" + BusOf(port_path) : port_path.substr(0, dot);
}

std::string Hex(const Bytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02X}", byte);
  return text;
}

/// A device in umockdev's language; without a node nobody can open it.
std::string Describe(const std::string& folder, const UsbPlug& plug, int number, bool with_node) {
  const std::string bus = plug.port_path.starts_with("usb") ? plug.port_path.substr(3) : BusOf(plug.port_path);
  const std::string node = fmt::format("bus/usb/{:03}/{:03}", std::stoi(bus), number);
  std::string text = fmt::format("P: {}\n", folder);
  if (with_node) text += fmt::format("N: {}\nE: DEVNAME=/dev/{}\n", node, node);
  text += fmt::format("E: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: BUSNUM={:03}\nE: DEVNUM={:03}\n", std::stoi(bus),
                      number);
  text += fmt::format("A: busnum={}\\n\nA: devnum={}\\n\nA: speed={}\\n\nA: bConfigurationValue=1\\n\n", bus, number,
                      plug.speed_mbit_per_s);
  text +=
      fmt::format("A: manufacturer={}\\n\nA: product={}\\n\nA: serial={}\\n\n", plug.vendor, plug.model, plug.serial);
  return text + fmt::format("H: descriptors={}\n", Hex(plug.descriptors));
}

}  // namespace

Result<std::unique_ptr<UsbTestbed>> UsbTestbed::Start() {
  std::unique_ptr<UsbTestbed> testbed(new UsbTestbed(GObjectPointer<UMockdevTestbed>(umockdev_testbed_new())));
  if (umockdev_in_mock_environment() == FALSE) {  // it looks whether /sys is the test bed's: not before there is one
    return Fail(ErrorCode::kUnsupported, "emulated USB: this program does not run under umockdev-wrapper");
  }
  return testbed;
}

UsbTestbed::~UsbTestbed() {
  UnplugAll();
}

void UsbTestbed::UnplugAll() {
  while (!plugged_.empty()) Unplug(std::string(plugged_.begin()->first));
  for (auto hub = hubs_.rbegin(); hub != hubs_.rend(); ++hub) {  // those that hang on others first
    if (!hub->first.starts_with("usb")) Remove(hub->second);
  }
  std::erase_if(hubs_, [](const auto& hub) { return !hub.first.starts_with("usb"); });
}

void UsbTestbed::Remove(const std::string& folder) {
  const std::string syspath = "/sys" + folder;
  umockdev_testbed_uevent(testbed_.get(), syspath.c_str(), "remove");
  umockdev_testbed_remove_device(testbed_.get(), syspath.c_str());
}

Result<void> UsbTestbed::Add(const std::string& description) {
  GError* error = nullptr;
  if (umockdev_testbed_add_from_string(testbed_.get(), description.c_str(), &error) != FALSE) return {};
  const std::string why = error->message;
  g_error_free(error);
  return Fail(ErrorCode::kIo, "emulated USB: the device cannot be added: {}", why);
}

Result<void> UsbTestbed::AddHub(const std::string& port_path) {
  if (hubs_.contains(port_path)) return {};
  const bool root = port_path.starts_with("usb");
  if (!root) {
    if (Result<void> above = AddHub(HubOf(port_path)); !above) return above;
  }
  const std::string folder = fmt::format("{}/{}", root ? kController : hubs_[HubOf(port_path)], port_path);
  hubs_[port_path] = folder;
  return Add(Describe(folder, {.port_path = port_path, .descriptors = HubDescriptors()}, ++last_device_, false));
}

Result<void> UsbTestbed::Plug(const UsbPlug& plug, const std::shared_ptr<UsbFunction>& function) {
  Unplug(plug.port_path);
  if (Result<void> hub = AddHub(HubOf(plug.port_path)); !hub) return hub;
  function->PowerOn();
  const int number = ++last_device_;
  Plugged plugged{.folder = fmt::format("{}/{}", hubs_[HubOf(plug.port_path)], plug.port_path),
                  .node_path = fmt::format("/dev/bus/usb/{:03}/{:03}", std::stoi(BusOf(plug.port_path)), number),
                  .node = std::make_shared<UsbfsNode>(
                      function, plug.descriptors,
                      std::vector<std::string>{plug.vendor, plug.model, plug.serial, "GUID" + plug.serial})};
  GError* error = nullptr;
  if (umockdev_testbed_attach_ioctl(testbed_.get(), plugged.node_path.c_str(), plugged.node->MakeHandler().get(),
                                    &error) == FALSE) {
    const std::string why = error->message;
    g_error_free(error);
    return Fail(ErrorCode::kIo, "emulated USB: {} cannot be served: {}", plugged.node_path, why);
  }
  if (Result<void> added = Add(Describe(plugged.folder, plug, number, true)); !added) return added;
  plugged_.emplace(plug.port_path, std::move(plugged));
  return {};
}

void UsbTestbed::Unplug(const std::string& port_path) {
  const auto found = plugged_.extract(port_path);
  if (!found) return;
  const Plugged& plugged = found.mapped();
  plugged.node->Unplug();
  Remove(plugged.folder);
  umockdev_testbed_detach_ioctl(testbed_.get(), plugged.node_path.c_str(), nullptr);
}

}  // namespace rigcal::sim
