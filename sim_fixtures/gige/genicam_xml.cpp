#include "sim_fixtures/gige/genicam_xml.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <vector>

#include "sim_fixtures/gige/gige_pixel_format.h"
#include "sim_fixtures/gige/gige_registers.h"

namespace rigcal::sim {
namespace {

using Entries = std::vector<std::pair<std::string_view, std::uint32_t>>;

/// Grows feature by feature.
class Description {
 public:
  void Whole(std::string_view name, std::uint32_t address, std::string_view access, const std::string& limits = "") {
    Register("IntReg", name, address, access, "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>");
    Add(fmt::format("<Integer Name=\"{0}\"><pValue>{0}Reg</pValue>{1}</Integer>", name, limits), name);
  }
  void Real(std::string_view name, std::uint32_t address, std::string_view access, const std::string& limits = "") {
    Register("FloatReg", name, address, access, "<Endianess>BigEndian</Endianess>");
    Add(fmt::format("<Float Name=\"{0}\"><pValue>{0}Reg</pValue>{1}</Float>", name, limits), name);
  }
  void Choice(std::string_view name, std::uint32_t address, const Entries& entries) {
    Register("IntReg", name, address, "RW", "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>");
    std::string text;
    for (const auto& [entry, value] : entries) {
      text += fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>", entry, value);
    }
    Add(fmt::format("<Enumeration Name=\"{0}\">{1}<pValue>{0}Reg</pValue></Enumeration>", name, text), name);
  }
  void Command(std::string_view name, std::uint32_t address, std::uint32_t value) {
    Register("IntReg", name, address, "RW", "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>");
    Add(fmt::format("<Command Name=\"{0}\"><pValue>{0}Reg</pValue><CommandValue>{1}</CommandValue></Command>", name,
                    value),
        name);
  }

  /// Bits of the stream's packet register, counted as the description does, from the highest.
  void PacketBits(const std::string& register_name, const std::string& bits) {
    nodes_ += fmt::format(
        "<MaskedIntReg Name=\"{}\"><Address>0x{:x}</Address><Length>4</Length><AccessMode>RW</AccessMode>"
        "<pPort>Device</pPort><Cachable>NoCache</Cachable>{}<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>"
        "</MaskedIntReg>\n",
        register_name, bootstrap::kStreamPacket, bits);
  }
  void PacketSize(const GigeLimits& limits) {
    PacketBits("PacketSizeReg", "<LSB>31</LSB><MSB>16</MSB>");
    Add(fmt::format("<Integer Name=\"GevSCPSPacketSize\"><pValue>PacketSizeReg</pValue><Min>{}</Min><Max>{}</Max>"
                    "<Inc>{}</Inc></Integer>",
                    limits.least_packet_bytes, limits.most_packet_bytes, limits.packet_step_bytes),
        "GevSCPSPacketSize");
    PacketBits("TestPacketReg", "<Bit>0</Bit>");
    Add("<Command "
        "Name=\"GevSCPSFireTestPacket\"><pValue>TestPacketReg</pValue><CommandValue>1</CommandValue></Command>",
        "GevSCPSFireTestPacket");
  }

  [[nodiscard]] std::string Text() const {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<RegisterDescription ModelName=\"Studio\" VendorName=\"rigcal\" ToolTip=\"simulated camera\" "
        "StandardNameSpace=\"GEV\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" "
        "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" "
        "ProductGuid=\"4b8e3ad2-6ad1-4a9e-8d58-1f6d5c6a2b10\" "
        "VersionGuid=\"9a4f0c7e-3f0e-4c53-a1d8-7d2b0a5c9e21\" xmlns=\"http://www.genicam.org/GenApi/Version_1_1\" "
        "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
        "xsi:schemaLocation=\"http://www.genicam.org/GenApi/Version_1_1 "
        "http://www.genicam.org/GenApi/GenApiSchema_Version_1_1.xsd\">\n"
        "<Category Name=\"Root\" NameSpace=\"Standard\">{}</Category>\n{}<Port Name=\"Device\"/>\n"
        "</RegisterDescription>\n",
        names_, nodes_);
  }

 private:
  void Add(const std::string& node, std::string_view name) {
    nodes_ += node + "\n";
    names_ += fmt::format("<pFeature>{}</pFeature>", name);
  }
  void Register(std::string_view kind, std::string_view name, std::uint32_t address, std::string_view access,
                std::string_view rest) {
    nodes_ += fmt::format(
        "<{0} Name=\"{1}Reg\"><Address>0x{2:x}</Address><Length>4</Length><AccessMode>{3}</AccessMode>"
        "<pPort>Device</pPort><Cachable>NoCache</Cachable>{4}</{0}>\n",
        kind, name, address, access, rest);
  }

  std::string nodes_, names_;
};

std::string Between(double least, double most) {
  return fmt::format("<Min>{}</Min><Max>{}</Max>", least, most);
}

void AddImageFeatures(Description& description, const GigeLimits& limits) {
  const std::string step = fmt::format("<Inc>{}</Inc>", limits.region_step_px);
  description.Whole("SensorWidth", own::kSensorWidth, "RO");
  description.Whole("SensorHeight", own::kSensorHeight, "RO");
  description.Whole("Width", own::kWidth, "RW", "<Min>8</Min><pMax>SensorWidth</pMax>" + step);
  description.Whole("Height", own::kHeight, "RW", "<Min>8</Min><pMax>SensorHeight</pMax>" + step);
  description.Whole("OffsetX", own::kOffsetX, "RW", "<Min>0</Min><pMax>SensorWidth</pMax>" + step);
  description.Whole("OffsetY", own::kOffsetY, "RW", "<Min>0</Min><pMax>SensorHeight</pMax>" + step);
  Entries formats;
  for (const GigePixelFormat& format : GigePixelFormats()) formats.emplace_back(format.name, format.code);
  description.Choice("PixelFormat", own::kPixelFormat, formats);
  description.Whole("PayloadSize", own::kPayload_bytes, "RO");
}

void AddShotFeatures(Description& description, const GigeLimits& limits) {
  description.Choice("AcquisitionMode", own::kAcquisitionMode, {{"Continuous", 0}});
  description.Command("AcquisitionStart", own::kStart, 1);
  description.Command("AcquisitionStop", own::kStop, 1);
  description.Choice("TriggerSelector", own::kTriggerSelector, {{"FrameStart", 0}});
  description.Choice("TriggerMode", own::kTriggerMode, {{"Off", 0}, {"On", 1}});
  description.Choice("TriggerSource", own::kTriggerSource,
                     {{"Software", own::kSoftwareSource}, {"Line1", own::kLine1Source}});
  description.Choice("TriggerActivation", own::kTriggerActivation, {{"RisingEdge", 0}});
  description.Command("TriggerSoftware", own::kTriggerSoftware, 1);
  description.Real("ExposureTime", own::kExposure_us, "RW", Between(limits.least_exposure_us, limits.most_exposure_us));
  description.Real("Gain", own::kGain_db, "RW", Between(limits.least_gain_db, limits.most_gain_db));
  description.Real("Gamma", own::kGamma, "RW", Between(0.1, 4));
  description.Real("DeviceTemperature", own::kTemperature, "RO");
}

}  // namespace

std::string GenicamXml(const GigeLimits& limits) {
  Description description;
  AddImageFeatures(description, limits);
  AddShotFeatures(description, limits);
  description.PacketSize(limits);
  description.Whole("GevSCPD", bootstrap::kStreamDelay_ticks, "RW");
  return description.Text();
}

}  // namespace rigcal::sim
