#include "drivers/usb/check_usb_descriptors.h"

#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>

#include "core/base/random.h"
#include "tests/drivers/usb/camera_bytes.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

/// A copy that ends where memory ends: a read beyond it kills the program.
class AtTheEndOfMemory {
 public:
  AtTheEndOfMemory() : page_(static_cast<std::size_t>(sysconf(_SC_PAGESIZE))) {
    memory_ = mmap(nullptr, 2 * page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    EXPECT_NE(memory_, MAP_FAILED);
    EXPECT_EQ(mprotect(static_cast<char*>(memory_) + page_, page_, PROT_NONE), 0);
  }
  ~AtTheEndOfMemory() { munmap(memory_, 2 * page_); }
  AtTheEndOfMemory(const AtTheEndOfMemory&) = delete;
  AtTheEndOfMemory& operator=(const AtTheEndOfMemory&) = delete;

  std::span<const std::uint8_t> Copy(std::span<const std::uint8_t> bytes) {
    std::uint8_t* begin = static_cast<std::uint8_t*>(memory_) + page_ - bytes.size();
    std::ranges::copy(bytes, begin);
    return {begin, bytes.size()};
  }

 private:
  std::size_t page_;
  void* memory_ = nullptr;
};

TEST(CheckUsbDescriptors, FindsACameraWellFormed) {
  const UsbDescriptorCheck check = CheckUsbDescriptors(kCameraBytes);
  EXPECT_TRUE(check.says_usb3_vision);
  EXPECT_EQ(check.flaw, "");
  EXPECT_TRUE(check.super_speed_able);
}

TEST(CheckUsbDescriptors, KnowsACameraThatIsMadeForUsb2) {
  std::vector<std::uint8_t> bytes = kCameraBytes;
  bytes[63] = 0x04;  // bmSpeedSupport: 480 Mbit/s alone
  const UsbDescriptorCheck check = CheckUsbDescriptors(bytes);
  EXPECT_EQ(check.flaw, "");
  EXPECT_FALSE(check.super_speed_able);
}

TEST(CheckUsbDescriptors, LeavesOtherDevicesAlone) {
  const std::vector<std::uint8_t> keyboard = {18,   1,    0,    2, 0, 0, 0,    8,    0x6D,
                                              0x04, 1,    2,    3, 4, 1, 2,    0,    1,   //
                                              9,    2,    34,   0, 1, 1, 0,    0xA0, 50,  //
                                              9,    4,    0,    0, 1, 3, 1,    1,    0,   //
                                              9,    0x21, 0x10, 1, 0, 1, 0x22, 65,   0,   //
                                              7,    5,    0x81, 3, 8, 0, 10};
  const UsbDescriptorCheck check = CheckUsbDescriptors(keyboard);
  EXPECT_FALSE(check.says_usb3_vision);
  EXPECT_EQ(check.flaw, "");
  std::vector<std::uint8_t> webcam = kCameraBytes;  // of the same device class, as most webcams are
  for (const std::size_t subclass : {32, 41, 96}) webcam[subclass] = 0x0E;
  EXPECT_FALSE(CheckUsbDescriptors(webcam).says_usb3_vision);
  webcam[18 + 4] = 3;  // one interface more than there is: read to its end all the same, and no camera
  EXPECT_FALSE(CheckUsbDescriptors(webcam).says_usb3_vision);
}

struct Damage {
  std::size_t offset;
  int value;  ///< that it is given
  const char* flaw;
};

const std::vector<Damage> kDamages = {
    Damage{0, 200, "offset 0: the device descriptor has a bLength of 200, not 18"},
    Damage{0, 0, "offset 0: the device descriptor has a bLength of 0, not 18"},
    Damage{1, 2, "offset 1: the descriptor has type 0x02, not that of a device (0x01)"},
    Damage{4, 0, "offset 4: the device is of class 00/02/01, not EF/02/01"},
    Damage{17, 0, "offset 17: the device has 0 configurations"},
    Damage{18, 8, "offset 18: the configuration descriptor has a bLength of 8, not 9"},
    Damage{19, 4, "offset 19: the descriptor has type 0x04, not that of a configuration (0x02)"},
    Damage{20, 93, "offset 20: the configuration has a wTotalLength of 93, and 94 bytes"},
    Damage{20, 95, "offset 20: the configuration has a wTotalLength of 95, and 94 bytes"},
    Damage{20, 3, "offset 20: the configuration has a wTotalLength of 3, and 94 bytes"},
    Damage{21, 255, "offset 20: the configuration has a wTotalLength of 65374, and 94 bytes"},
    Damage{22, 0, "offset 22: the configuration has 0 interfaces, not 1 to 32"},
    Damage{22, 33, "offset 22: the configuration has 33 interfaces, not 1 to 32"},
    Damage{22, 3, "offset 22: the configuration has a bNumInterfaces of 3, and 2 interfaces"},
    Damage{22, 1, "offset 22: the configuration has a bNumInterfaces of 1, and 2 interfaces"},
    Damage{27, 0, "offset 27: a descriptor has a bLength of 0, and 85 bytes of the configuration are left"},
    Damage{27, 1, "offset 27: a descriptor has a bLength of 1, and 85 bytes of the configuration are left"},
    Damage{27, 86, "offset 27: a descriptor has a bLength of 86, and 85 bytes of the configuration are left"},
    Damage{27, 17, "offset 27: the interface association descriptor has a bLength of 17, not 8"},
    Damage{28, 0x77, "offset 18: the configuration has no interface association of class EF/05"},
    Damage{29, 1, "offset 37: interface 0 is outside its association of 2 from 1"},
    Damage{30, 1, "offset 92: interface 1 is outside its association of 1 from 0"},
    Damage{31, 0, "offset 18: the configuration has no interface association of class EF/05"},
    Damage{35, 7, "offset 35: the interface descriptor has a bLength of 7, not 9"},
    Damage{35, 29, "offset 35: the interface descriptor has a bLength of 29, not 9"},
    Damage{36, 5, "offset 35: an endpoint descriptor before any interface"},
    Damage{39, 3, "offset 39: interface 0.0 has a bNumEndpoints of 3, and 2 endpoints"},
    Damage{39, 0, "offset 39: interface 0.0 has a bNumEndpoints of 0, and 2 endpoints"},
    Damage{41, 4, "offset 18: the configuration has no control interface (EF/05/00)"},
    Damage{42, 2, "offset 39: the stream interface has 2 endpoints, not 1"},
    Damage{42, 7, "offset 42: interface 0 has protocol 7, not 0 to 2"},
    Damage{44, 40, "offset 44: the device information descriptor has a bLength of 40, not 20"},
    Damage{44, 19, "offset 44: the device information descriptor has a bLength of 19, not 20"},
    Damage{45, 0x25, "offset 35: no device information of 20 bytes follows the control interface"},
    Damage{46, 2, "offset 35: no device information of 20 bytes follows the control interface"},
    Damage{55, 0, "offset 55: the device information has no GUID: its string index is 0"},
    Damage{64, 6, "offset 64: the endpoint descriptor has a bLength of 6, not 7"},
    Damage{64, 9, "offset 64: the endpoint descriptor has a bLength of 9, not 7"},
    Damage{65, 4, "offset 64: the interface descriptor has a bLength of 7, not 9"},
    Damage{65, 2, "offset 65: a descriptor of type 0x02 in the middle of a configuration"},
    Damage{66, 0x01, "offset 66: the control interface has endpoints 0x01 and 0x01, not one number both ways"},
    Damage{66, 0x83, "offset 66: the control interface has endpoints 0x83 and 0x01, not one number both ways"},
    Damage{66, 0x80,
           "offset 66: endpoint 0x80 has attributes 0x02 and packets of 1024 bytes, one of a camera is "
           "bulk (0x02)"},
    Damage{67, 3,
           "offset 66: endpoint 0x81 has attributes 0x03 and packets of 1024 bytes, one of a camera is "
           "bulk (0x02)"},
    Damage{69, 0,
           "offset 66: endpoint 0x81 has attributes 0x02 and packets of 0 bytes, one of a camera is "
           "bulk (0x02)"},
    Damage{71, 7, "offset 71: the endpoint companion descriptor has a bLength of 7, not 6"},
    Damage{92, 0, "offset 22: the configuration has a bNumInterfaces of 2, and 1 interfaces"},
    Damage{94, 0, "offset 94: interface 1.0 has a bNumEndpoints of 0, and 1 endpoints"},
    Damage{96, 4, "offset 18: the configuration has no stream interface (EF/05/02)"},
    Damage{97, 0, "offset 97: interface 1.0 is a second one of protocol 0"},
    Damage{97, 1, "offset 18: the configuration has no stream interface (EF/05/02)"},
    Damage{101, 0x02, "offset 101: the stream interface has endpoint 0x02, which is no input"},
    Damage{106, 12, "offset 106: a descriptor has a bLength of 12, and 6 bytes of the configuration are left"}};

TEST(CheckUsbDescriptors, SaysWhatIsWrong) {
  for (const Damage& damage : kDamages) {
    std::vector<std::uint8_t> bytes = kCameraBytes;
    bytes[damage.offset] = static_cast<std::uint8_t>(damage.value);
    const UsbDescriptorCheck check = CheckUsbDescriptors(bytes);
    EXPECT_TRUE(check.says_usb3_vision) << damage.flaw;
    EXPECT_EQ(check.flaw, damage.flaw);
  }
}

TEST(CheckUsbDescriptors, ASecondConfigurationIsNotItsConcern) {
  std::vector<std::uint8_t> bytes = kCameraBytes;
  bytes[17] = 2;
  bytes.insert(bytes.end(), {9, 2, 9, 0, 0, 2, 0, 0x80, 50});
  EXPECT_EQ(CheckUsbDescriptors(bytes).flaw, "");
}

TEST(CheckUsbDescriptors, EveryTruncationIsAFlawAndNothingBeyondIsRead) {
  AtTheEndOfMemory memory;
  for (std::size_t size = 0; size < kCameraBytes.size(); ++size) {
    std::vector<std::uint8_t> bytes(kCameraBytes.begin(), kCameraBytes.begin() + static_cast<std::ptrdiff_t>(size));
    const UsbDescriptorCheck check = CheckUsbDescriptors(memory.Copy(bytes));
    EXPECT_NE(check.flaw, "") << size;
    EXPECT_EQ(check.says_usb3_vision, size >= 18) << size;
    if (size < 18 + 9 + 2 || size == 106) continue;  // 106: all but a companion, which no USB2 device has
    // the same with a total length that says so: the walk itself must see it
    bytes[20] = static_cast<std::uint8_t>(size - 18);
    EXPECT_NE(CheckUsbDescriptors(memory.Copy(bytes)).flaw, "") << size;
  }
}

TEST(CheckUsbDescriptors, AShortDescriptorOfAnyKindAtTheEndIsNotReadBeyond) {
  AtTheEndOfMemory memory;
  for (int after = 44; after <= 112; after += 68) {  // right behind the control interface, and at the end
    for (int type = 0; type < 256; ++type) {
      for (int length = 2; length < 9; ++length) {
        std::vector<std::uint8_t> bytes(kCameraBytes.begin(), kCameraBytes.begin() + after);
        bytes.resize(bytes.size() + static_cast<std::size_t>(length), 0xFF);
        bytes[static_cast<std::size_t>(after)] = static_cast<std::uint8_t>(length);
        bytes[static_cast<std::size_t>(after) + 1] = static_cast<std::uint8_t>(type);
        bytes[20] = static_cast<std::uint8_t>(bytes.size() - 18);
        EXPECT_TRUE(CheckUsbDescriptors(memory.Copy(bytes)).says_usb3_vision) << type << ", " << length;
        bytes[after == 44 ? 41 : 96] = 0x0E;  // the interface before it is none of a camera
        EXPECT_TRUE(CheckUsbDescriptors(memory.Copy(bytes)).says_usb3_vision) << type << ", " << length;
      }
    }
  }
}

TEST(CheckUsbDescriptors, TenThousandMutationsReadNothingBeyond) {
  AtTheEndOfMemory memory;
  Random random(4);
  int well_formed = 0;
  for (int i = 0; i < 10000; ++i) {
    std::vector<std::uint8_t> bytes = kCameraBytes;
    const std::size_t num_changes = 1 + random.Index(4);
    for (std::size_t change = 0; change < num_changes; ++change) {
      const std::size_t at = random.Index(bytes.size());
      const auto value = static_cast<std::uint8_t>(random.Index(256));
      switch (random.Index(4)) {
        case 0:
          bytes[at] = value;
          break;
        case 1:
          bytes.resize(at + 1);
          break;
        case 2:
          bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), value);
          break;
        default:
          bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1U << random.Index(8));
          break;
      }
    }
    if (bytes.size() >= 22 && random.Index(2) == 0) {  // lengths that agree, so that the walk gets further
      bytes[20] = static_cast<std::uint8_t>(bytes.size() - 18), bytes[21] = 0;
    }
    const UsbDescriptorCheck check = CheckUsbDescriptors(memory.Copy(bytes));
    if (!check.flaw.empty()) {
      EXPECT_THAT(check.flaw, HasSubstr("offset "));
    }
    well_formed += check.flaw.empty() && check.says_usb3_vision ? 1 : 0;
  }
  EXPECT_GT(well_formed, 100) << "ids and strings may be anything";
  EXPECT_LT(well_formed, 5000);
}

}  // namespace
}  // namespace rigcal
