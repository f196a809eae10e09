#include "drivers/usb/usb_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNodeFolder = "/dev/bus/usb";
constexpr const char* kProgramsDriver = "usbfs";  ///< of an interface that a program has taken
constexpr std::size_t kVersionOffset = 12;        ///< of bcdDevice in the device descriptor

/// What the file holds; empty when it is not there.
std::string Contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Its first line; UTF-8 becomes ASCII as libusb makes it from UTF-16, one '?' for each of its two bytes.
std::string Line(const fs::path& path) {
  constexpr unsigned char kAsciiEnd = 0x80, kLeadBegin = 0xC0, kFourByteLeadBegin = 0xF0;
  std::string line;
  for (const char letter : Contents(path)) {
    const auto byte = static_cast<unsigned char>(letter);
    if (letter == '\n') break;
    if (byte < kAsciiEnd) line += letter;
    if (byte >= kLeadBegin) line += byte >= kFourByteLeadBegin ? "??" : "?";
  }
  return line;
}

template <typename Number>
Number NumberIn(const fs::path& path) {
  Number number{};
  std::istringstream(Line(path)) >> number;
  return number;
}

/// Whether one of the device's interfaces is in the hands of a program. Their folders lie in the device's own.
bool Held(const fs::path& device, const std::string& port_path) {
  std::error_code gone;
  for (const fs::directory_entry& entry : fs::directory_iterator(device, gone)) {
    if (!entry.path().filename().string().starts_with(port_path + ":")) continue;
    const fs::path driver = fs::read_symlink(entry.path() / "driver", gone);
    if (!gone && driver.filename() == kProgramsDriver) return true;
  }
  return false;
}

}  // namespace

std::optional<UsbDevice> ReadUsbDevice(const std::string& port_path, const std::string& folder) {
  const fs::path path = fs::path(folder) / port_path;
  const std::string descriptors = Contents(path / "descriptors");
  if (descriptors.empty()) return std::nullopt;
  UsbDevice device{.port_path = port_path,
                   .vendor = Line(path / "manufacturer"),
                   .model = Line(path / "product"),
                   .serial = Line(path / "serial"),
                   .speed_mbit_per_s = NumberIn<double>(path / "speed"),
                   .node = fmt::format("{}/{:03}/{:03}", kNodeFolder, NumberIn<int>(path / "busnum"),
                                       NumberIn<int>(path / "devnum")),
                   .held = Held(path, port_path),
                   .descriptors = {descriptors.begin(), descriptors.end()}};
  if (device.descriptors.size() > kVersionOffset + 1) {
    device.firmware =
        fmt::format("{:x}.{:02x}", device.descriptors[kVersionOffset + 1], device.descriptors[kVersionOffset]);
  }
  return device;
}

std::vector<UsbDevice> ReadUsbDevices(const std::string& folder) {
  std::vector<UsbDevice> devices;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (name.find(':') != std::string::npos) continue;  // an interface of a device
    if (std::optional<UsbDevice> device = ReadUsbDevice(name, folder)) devices.push_back(std::move(*device));
  }
  std::ranges::sort(devices, {}, &UsbDevice::port_path);
  return devices;
}

std::string Trimmed(std::string text) {
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace rigcal
