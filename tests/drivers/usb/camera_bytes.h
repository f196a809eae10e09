#pragma once

#include <cstdint>
#include <vector>

namespace rigcal {

/// The descriptors of a USB3 Vision camera, as sysfs has them: device, configuration, association, control interface
/// with device information and two endpoints, stream interface with one. libusb and Aravis accept them.
inline const std::vector<std::uint8_t> kCameraBytes = {
    18, 0x01, 0x00, 0x03, 0xEF, 0x02, 0x01, 9,    0x09, 0x12, 0x01, 0x00, 0x10, 0x02, 1, 2, 3, 1,  // 0 device
    9,  0x02, 94,   0,    2,    1,    0,    0xC0, 0x32,                                            // 18
    8,  0x0B, 0,    2,    0xEF, 0x05, 0x00, 0,                                                     // 27
    9,  0x04, 0,    0,    2,    0xEF, 0x05, 0x00, 0,                                               // 35 control
    20, 0x24, 0x01, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 4,    1,    2,    0, 0, 0, 3, 0, 0x08,  // 44
    7,  0x05, 0x81, 0x02, 0x00, 0x04, 0,                                                                    // 64
    6,  0x30, 0,    0,    0,    0,                                                                          // 71
    7,  0x05, 0x01, 0x02, 0x00, 0x04, 0,                                                                    // 77
    6,  0x30, 0,    0,    0,    0,                                                                          // 84
    9,  0x04, 1,    0,    1,    0xEF, 0x05, 0x02, 0,                                                        // 90 stream
    7,  0x05, 0x82, 0x02, 0x00, 0x04, 0,                                                                    // 99
    6,  0x30, 15,   0,    0,    0,                                                                          // 106
};

}  // namespace rigcal
