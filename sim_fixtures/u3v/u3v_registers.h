#pragma once

#include <cstdint>

namespace rigcal::sim {

/// Registers of a simulated USB3 Vision camera; numbers have their lowest byte first.

/// Of every device (GenCP: ABRM), from 0.
namespace abrm {
inline constexpr std::size_t kVersion = 0x000, kVendor = 0x004, kModel = 0x044, kDeviceVersion = 0x0c4, kSerial = 0x144;
inline constexpr std::size_t kText_bytes = 64;
inline constexpr std::size_t kCapability = 0x1c4, kResponse_ms = 0x1cc, kManifest = 0x1d0, kTechnology = 0x1d8;
}  // namespace abrm

/// Of USB3 Vision (SBRM).
namespace sbrm {
inline constexpr std::size_t kBegin = 0x1000;
inline constexpr std::size_t kVersion = kBegin, kMostCommand_bytes = kBegin + 0x14, kMostAnswer_bytes = kBegin + 0x18,
                             kNumStreams = kBegin + 0x1c, kStream = kBegin + 0x20, kStream_bytes = kBegin + 0x28;
}  // namespace sbrm

/// Of the stream (SIRM).
namespace sirm {
inline constexpr std::size_t kBegin = 0x1100;
inline constexpr std::size_t kInfo = kBegin, kControl = kBegin + 0x04, kPayload_bytes = kBegin + 0x08,
                             kLeader_bytes = kBegin + 0x10, kTrailer_bytes = kBegin + 0x14;
inline constexpr std::uint32_t kEnabled = 1;  ///< of kControl
}  // namespace sirm

/// The list of descriptions: one, of 64 bytes.
namespace manifest {
inline constexpr std::size_t kBegin = 0x1200;
inline constexpr std::size_t kCount = kBegin, kXmlAddress = kBegin + 0x10, kXml_bytes = kBegin + 0x18;
}  // namespace manifest

/// The camera's own, as its description tells. 32 bits; exposure, gain, gamma and temperature are IEEE 754 floats.
namespace feature {
inline constexpr std::size_t kSensorWidth = 0x2000, kSensorHeight = 0x2004;
inline constexpr std::size_t kWidth = 0x2010, kHeight = 0x2014, kOffsetX = 0x2018, kOffsetY = 0x201c;
inline constexpr std::size_t kPixelFormat = 0x2020, kPayload_bytes = 0x2024;
inline constexpr std::size_t kAcquisitionMode = 0x2030, kStart = 0x2034, kStop = 0x2038;
inline constexpr std::size_t kTriggerSelector = 0x2040, kTriggerMode = 0x2044, kTriggerSource = 0x2048;
inline constexpr std::size_t kTriggerActivation = 0x204c, kTriggerSoftware = 0x2050;
inline constexpr std::size_t kExposure_us = 0x2060, kGain_db = 0x2064, kGamma = 0x2068, kTemperature = 0x206c;
}  // namespace feature

inline constexpr std::size_t kXmlBegin = 0x4000;
inline constexpr std::size_t kMemory_bytes = 0xc000;

}  // namespace rigcal::sim
