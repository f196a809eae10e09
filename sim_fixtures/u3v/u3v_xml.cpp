#include "sim_fixtures/u3v/u3v_xml.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <vector>

#include "sim_fixtures/u3v/u3v_registers.h"

namespace rigcal::sim {
namespace {

constexpr const char* kWhole = "IntReg";
constexpr const char* kReal = "FloatReg";

/// Grows feature by feature.
class Description {
 public:
  /// A number of kind kWhole ("Integer") or kReal ("Float").
  void Number(const char* kind, std::string_view name, std::size_t address, std::string_view access,
              const std::string& limits = "") {
    Register(kind, name, address, access);
    Feature(kind == kReal ? "Float" : "Integer", name, fmt::format("<pValue>{}Reg</pValue>{}", name, limits));
  }
  void Choice(std::string_view name, std::size_t address,
              const std::vector<std::pair<std::string_view, std::uint32_t>>& entries) {
    Register(kWhole, name, address, "RW");
    std::string text;
    for (const auto& [entry, value] : entries) {
      text += fmt::format("<EnumEntry Name=\"{}\"><Value>{}</Value></EnumEntry>", entry, value);
    }
    Feature("Enumeration", name, fmt::format("{}<pValue>{}Reg</pValue>", text, name));
  }
  void Command(std::string_view name, std::size_t address) {
    Register(kWhole, name, address, "RW");
    Feature("Command", name, fmt::format("<pValue>{}Reg</pValue><CommandValue>1</CommandValue>", name));
  }
  void Text(std::string_view name, std::size_t address) {
    Feature("StringReg", name,
            fmt::format("<Address>{}</Address><Length>{}</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>",
                        address, abrm::kText_bytes));
  }
  [[nodiscard]] std::string All() const {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<RegisterDescription ModelName=\"Emulated\" VendorName=\"rigcal\" "
        "StandardNameSpace=\"None\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" "
        "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" "
        "ProductGuid=\"2c1b7f0e-5e38-4a0c-9f64-6d1c0b8a7e11\" VersionGuid=\"c7a3d1b4-0d5f-4b7e-8a52-94e0f3b26d70\" "
        "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n"
        "<Category Name=\"Root\" NameSpace=\"Standard\">{}</Category>\n{}<Port Name=\"Device\"/>\n"
        "</RegisterDescription>\n",
        names_, nodes_);
  }

 private:
  void Feature(std::string_view kind, std::string_view name, const std::string& rest) {
    nodes_ += fmt::format("<{0} Name=\"{1}\">{2}</{0}>\n", kind, name, rest);
    names_ += fmt::format("<pFeature>{}</pFeature>", name);
  }
  void Register(std::string_view kind, std::string_view name, std::size_t address, std::string_view access) {
    nodes_ += fmt::format(
        "<{0} Name=\"{1}Reg\"><Address>{2}</Address><Length>4</Length><AccessMode>{3}</AccessMode>"
        "<pPort>Device</pPort><Cachable>NoCache</Cachable>{4}<Endianess>LittleEndian</Endianess></{0}>\n",
        kind, name, address, access, kind == kWhole ? "<Sign>Unsigned</Sign>" : "");
  }

  std::string nodes_, names_;
};

}  // namespace

std::string U3vXml() {
  Description description;
  description.Text("DeviceVendorName", abrm::kVendor);
  description.Text("DeviceModelName", abrm::kModel);
  description.Text("DeviceSerialNumber", abrm::kSerial);
  description.Number(kWhole, "SensorWidth", feature::kSensorWidth, "RO");
  description.Number(kWhole, "SensorHeight", feature::kSensorHeight, "RO");
  description.Number(kWhole, "Width", feature::kWidth, "RW", "<Min>8</Min><pMax>SensorWidth</pMax><Inc>8</Inc>");
  description.Number(kWhole, "Height", feature::kHeight, "RW", "<Min>8</Min><pMax>SensorHeight</pMax><Inc>8</Inc>");
  description.Number(kWhole, "OffsetX", feature::kOffsetX, "RW", "<Min>0</Min><pMax>SensorWidth</pMax><Inc>8</Inc>");
  description.Number(kWhole, "OffsetY", feature::kOffsetY, "RW", "<Min>0</Min><pMax>SensorHeight</pMax><Inc>8</Inc>");
  description.Choice("PixelFormat", feature::kPixelFormat, {{"Mono8", 0x01080001}, {"Mono16", 0x01100007}});
  description.Number(kWhole, "PayloadSize", feature::kPayload_bytes, "RO");
  description.Choice("AcquisitionMode", feature::kAcquisitionMode, {{"Continuous", 0}});
  description.Command("AcquisitionStart", feature::kStart);
  description.Command("AcquisitionStop", feature::kStop);
  description.Choice("TriggerSelector", feature::kTriggerSelector, {{"FrameStart", 0}});
  description.Choice("TriggerMode", feature::kTriggerMode, {{"Off", 0}, {"On", 1}});
  description.Choice("TriggerSource", feature::kTriggerSource, {{"Software", 0}, {"Line1", 1}});
  description.Choice("TriggerActivation", feature::kTriggerActivation, {{"RisingEdge", 0}});
  description.Command("TriggerSoftware", feature::kTriggerSoftware);
  description.Number(kReal, "ExposureTime", feature::kExposure_us, "RW", "<Min>10</Min><Max>1000000</Max>");
  description.Number(kReal, "Gain", feature::kGain_db, "RW", "<Min>0</Min><Max>24</Max>");
  description.Number(kReal, "Gamma", feature::kGamma, "RW", "<Min>0.1</Min><Max>4</Max>");
  description.Number(kReal, "DeviceTemperature", feature::kTemperature, "RO");
  return description.All();
}

}  // namespace rigcal::sim
