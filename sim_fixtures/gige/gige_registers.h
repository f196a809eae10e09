#pragma once

#include <cstdint>

namespace rigcal::sim {

/// Bootstrap registers, where GigE Vision has them.
namespace bootstrap {
inline constexpr std::uint32_t kVersion = 0x0000, kDeviceMode = 0x0004, kMacHigh = 0x0008, kMacLow = 0x000c;
inline constexpr std::uint32_t kCurrentIp = 0x0024, kCurrentSubnet = 0x0034;
inline constexpr std::uint32_t kVendor = 0x0048, kModel = 0x0068, kFirmware = 0x0088, kSerial = 0x00d8;
inline constexpr std::uint32_t kDiscovery_bytes = 0x00f8;  ///< from 0: what a discovery answer holds
inline constexpr std::uint32_t kXmlUrl = 0x0200, kXmlUrl_bytes = 512, kNumInterfaces = 0x0600;
inline constexpr std::uint32_t kNumStreams = 0x0904, kCapabilities = 0x0934, kHeartbeat_ms = 0x0938;
inline constexpr std::uint32_t kTickFrequencyHigh = 0x093c, kTickFrequencyLow = 0x0940;
inline constexpr std::uint32_t kTimeControl = 0x0944, kTimeHigh = 0x0948, kTimeLow = 0x094c;
inline constexpr std::uint32_t kControl = 0x0a00, kControllerPort = 0x0a04, kControllerIp = 0x0a14;
inline constexpr std::uint32_t kStreamPort = 0x0d00, kStreamPacket = 0x0d04, kStreamDelay_ticks = 0x0d08;
inline constexpr std::uint32_t kStreamIp = 0x0d18, kStreamSourcePort = 0x0d1c;

inline constexpr std::uint32_t kExclusiveAccess = 1, kControlAccess = 2;                  ///< bits of kControl
inline constexpr std::uint32_t kCanConcatenate = 1, kCanWriteMemory = 2, kCanResend = 4;  ///< bits of kCapabilities
inline constexpr std::uint32_t kLatchTime = 2;                                            ///< of kTimeControl
inline constexpr std::uint32_t kFireTestPacket = 0x80000000, kPacketSizeMask = 0xffff;    ///< of kStreamPacket
}  // namespace bootstrap

/// The camera's own registers, as its GenICam description tells. Numbers are 32 bits; exposure, gain, gamma and
/// temperature are IEEE 754 floats.
namespace own {
inline constexpr std::uint32_t kSensorWidth = 0x8000, kSensorHeight = 0x8004;
inline constexpr std::uint32_t kWidth = 0x8010, kHeight = 0x8014, kOffsetX = 0x8018, kOffsetY = 0x801c;
inline constexpr std::uint32_t kPixelFormat = 0x8020, kPayload_bytes = 0x8024;
inline constexpr std::uint32_t kAcquisitionMode = 0x8030, kStart = 0x8034, kStop = 0x8038;
inline constexpr std::uint32_t kTriggerSelector = 0x8040, kTriggerMode = 0x8044, kTriggerSource = 0x8048;
inline constexpr std::uint32_t kTriggerActivation = 0x804c, kTriggerSoftware = 0x8050;
inline constexpr std::uint32_t kExposure_us = 0x8060, kGain_db = 0x8064, kGamma = 0x8068, kTemperature = 0x806c;
inline constexpr std::uint32_t kXml = 0x10000;  ///< the description itself

inline constexpr std::uint32_t kSoftwareSource = 0, kLine1Source = 1;  ///< values of kTriggerSource
}  // namespace own

inline constexpr std::uint32_t kMemory_bytes = 0x18000;

}  // namespace rigcal::sim
