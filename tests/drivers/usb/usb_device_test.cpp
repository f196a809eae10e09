#include "drivers/usb/usb_device.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "drivers/usb/find_usb_cameras.h"
#include "tests/drivers/usb/camera_bytes.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A folder that looks like the kernel's.
class UsbDeviceFolder : public ::testing::Test {
 protected:
  UsbDeviceFolder() { fs::create_directories(folder_); }
  ~UsbDeviceFolder() override { fs::remove_all(folder_); }

  void Put(const std::string& file, const std::string& text) {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
  }
  void PutDevice(const std::string& port_path, const std::string& speed, const std::vector<std::uint8_t>& bytes) {
    Put(port_path + "/descriptors", {bytes.begin(), bytes.end()});
    Put(port_path + "/speed", speed + "\n");
    Put(port_path + "/manufacturer", "M\xC3\xA4ker\xF0\x9F\x93\xB7\n");
    Put(port_path + "/product", "Camera  \n");
    Put(port_path + "/serial", "SN7 \n");
    Put(port_path + "/busnum", "1\n");
    Put(port_path + "/devnum", "12\n");
  }
  std::optional<FoundDevice> Row(const std::string& port_path) {
    const std::optional<UsbDevice> device = ReadUsbDevice(port_path, folder_.string());
    return device ? UsbCameraRow(*device) : std::nullopt;
  }

  fs::path folder_ = fs::temp_directory_path() / fmt::format("rigcal-usb-{}", getpid());
};

TEST_F(UsbDeviceFolder, SaysWhatTheKernelKnows) {
  PutDevice("1-2.3", "5000", kCameraBytes);
  const std::vector<UsbDevice> devices = ReadUsbDevices(folder_.string());
  ASSERT_EQ(devices.size(), 1U);
  EXPECT_EQ(devices[0].port_path, "1-2.3");
  EXPECT_EQ(devices[0].model, "Camera  ");
  EXPECT_EQ(devices[0].firmware, "2.10");
  EXPECT_EQ(devices[0].node, "/dev/bus/usb/001/012");
  EXPECT_EQ(devices[0].speed_mbit_per_s, 5000);
  EXPECT_FALSE(devices[0].held);
  EXPECT_EQ(devices[0].descriptors, kCameraBytes);

  const std::optional<FoundDevice> row = UsbCameraRow(devices[0]);
  ASSERT_TRUE(row);
  EXPECT_EQ(row->driver, "genicam");
  EXPECT_EQ(row->address, "1-2.3");
  EXPECT_EQ(row->serial, "SN7");
  EXPECT_EQ(row->model, "M?ker?? Camera");
  EXPECT_EQ(row->state, "free");
  EXPECT_EQ(row->problem, "");
}

TEST_F(UsbDeviceFolder, PassesOverInterfacesAndSortsByPort) {
  PutDevice("2-1", "5000", kCameraBytes);
  PutDevice("1-4", "5000", kCameraBytes);
  PutDevice("usb1", "480", {18, 1});
  PutDevice("1-4:1.0", "5000", kCameraBytes);
  std::vector<std::string> ports;
  for (const UsbDevice& device : ReadUsbDevices(folder_.string())) ports.push_back(device.port_path);
  EXPECT_THAT(ports, ::testing::ElementsAre("1-4", "2-1", "usb1"));
  EXPECT_FALSE(Row("usb1"));
  EXPECT_FALSE(Row("3-1"));
}

TEST_F(UsbDeviceFolder, WithoutUsbThereIsNothing) {
  EXPECT_TRUE(ReadUsbDevices((folder_ / "none").string()).empty());
}

TEST_F(UsbDeviceFolder, AUsb3CameraOnAUsb2PortIsReported) {
  PutDevice("1-1", "480", kCameraBytes);
  EXPECT_THAT(Row("1-1")->problem, HasSubstr("480 instead of 5000 Mbit/s"));
  std::vector<std::uint8_t> usb2 = kCameraBytes;
  usb2[63] = 0x04;  // made for it
  PutDevice("1-2", "480", usb2);
  EXPECT_EQ(Row("1-2")->problem, "");
  PutDevice("1-3", "10000", kCameraBytes);
  EXPECT_EQ(Row("1-3")->problem, "");
}

TEST_F(UsbDeviceFolder, MalformedDescriptorsAreReported) {
  std::vector<std::uint8_t> bytes = kCameraBytes;
  bytes[44] = 90;
  PutDevice("1-1", "5000", bytes);
  EXPECT_THAT(Row("1-1")->problem, HasSubstr("malformed (offset 44: a descriptor has a bLength of 90"));
  bytes.resize(20);  // does not even come to say that it is a camera
  PutDevice("1-2", "5000", bytes);
  EXPECT_THAT(Row("1-2")->problem, HasSubstr("breaks off after 2 of 9 bytes"));
}

TEST_F(UsbDeviceFolder, OneThatAProgramHoldsIsNotFree) {
  PutDevice("1-1", "5000", kCameraBytes);
  fs::create_directories(folder_ / "1-1" / "1-1:1.0");
  EXPECT_EQ(Row("1-1")->state, "free");
  fs::create_directory_symlink("../../../bus/usb/drivers/usbfs", folder_ / "1-1" / "1-1:1.0" / "driver");
  EXPECT_EQ(Row("1-1")->state, "held by a program on this machine");
}

}  // namespace
}  // namespace rigcal
