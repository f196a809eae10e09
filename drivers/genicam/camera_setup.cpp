#include "drivers/genicam/camera_setup.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "core/base/joined.h"

namespace rigcal {
namespace {

constexpr double kGammaOff = 1, kGammaTolerance = 1e-3;

/// One camera being set.
class Setup {
 public:
  Setup(ArvCamera* camera, const CameraSettings& settings) : camera_(camera), settings_(settings) {}

  Result<CameraFacts> All() {
    using Step = Result<void> (Setup::*)();
    for (const Step step : {&Setup::SetRegion, &Setup::SetPixelFormat, &Setup::SetExposure, &Setup::SetGain,
                            &Setup::SetTrigger, &Setup::SetPacketSize}) {
      if (Result<void> done = (this->*step)(); !done) return Fail(done.error());
    }
    return Facts();
  }

 private:
  template <typename... Args>
  [[nodiscard]] tl::unexpected<Error> Refuse(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) const {
    return Fail(code, "camera '{}': {}", settings_.id, fmt::format(format, std::forward<Args>(args)...));
  }
  [[nodiscard]] tl::unexpected<Error> Refused(std::string_view key) const {
    return Refuse(ErrorCode::kDevice, "it refuses {}: {}", key, error_.Text());
  }
  [[nodiscard]] bool Has(const char* feature) {
    return arv_camera_is_feature_available(camera_, feature, error_.Take()) != FALSE;
  }

  /// Sets a whole number within the camera's range and in its steps.
  Result<void> SetWhole(std::string_view key, const char* feature, int value) {
    gint64 least = 0, most = 0;
    arv_camera_get_integer_bounds(camera_, feature, &least, &most, error_.Take());
    if (error_.Happened()) return Refused(key);
    const gint64 step = std::max<gint64>(1, arv_camera_get_integer_increment(camera_, feature, error_.Take()));
    if (value < least || value > most || (value - least) % step != 0) {
      return Refuse(ErrorCode::kBadInput, "{} is {}, this camera allows {} to {} in steps of {}", key, value, least,
                    most, step);
    }
    arv_camera_set_integer(camera_, feature, value, error_.Take());
    if (error_.Happened()) return Refused(key);
    return {};
  }

  Result<void> SetRegion() {
    if (!settings_.region) return {};
    const SensorRegion& region = *settings_.region;
    gint sensor_width_px = 0, sensor_height_px = 0;
    arv_camera_get_sensor_size(camera_, &sensor_width_px, &sensor_height_px, error_.Take());
    if (error_.Happened()) return Refused("region_px");
    if (region.left_px + region.width_px > sensor_width_px || region.top_px + region.height_px > sensor_height_px) {
      return Refuse(ErrorCode::kBadInput, "region_px is [{}, {}, {}, {}], this camera's sensor has {} x {} pixels",
                    region.left_px, region.top_px, region.width_px, region.height_px, sensor_width_px,
                    sensor_height_px);
    }
    // From the corner, where every size fits; then to its place.
    for (const char* offset : {"OffsetX", "OffsetY"}) {
      if (Has(offset)) arv_camera_set_integer(camera_, offset, 0, error_.Take());
    }
    struct Part {
      std::string_view key;
      const char* feature;
      int value;
    };
    for (const Part& part :
         {Part{"region_px's width", "Width", region.width_px}, Part{"region_px's height", "Height", region.height_px},
          Part{"region_px's left", "OffsetX", region.left_px}, Part{"region_px's top", "OffsetY", region.top_px}}) {
      if (Result<void> set = SetWhole(part.key, part.feature, part.value); !set) return set;
    }
    return {};
  }

  Result<void> SetPixelFormat() {
    guint count = 0;
    const char** names = arv_camera_dup_available_pixel_formats_as_strings(camera_, &count, error_.Take());
    if (names == nullptr) return Refused("pixel_format");
    const std::vector<std::string> allowed(names, names + count);
    g_free(names);
    if (std::ranges::find(allowed, settings_.pixel_format) == allowed.end()) {
      return Refuse(ErrorCode::kBadInput, "pixel_format is \"{}\", this camera allows {}", settings_.pixel_format,
                    Joined(allowed, ", "));
    }
    arv_camera_set_pixel_format_from_string(camera_, settings_.pixel_format.c_str(), error_.Take());
    if (error_.Happened()) return Refused("pixel_format");
    return {};
  }

  Result<void> SetExposure() {
    if (!settings_.exposure_us) return {};
    if (arv_camera_is_exposure_auto_available(camera_, error_.Take()) != FALSE) {
      arv_camera_set_exposure_time_auto(camera_, ARV_AUTO_OFF, error_.Take());
    }
    double least = 0, most = 0;
    arv_camera_get_exposure_time_bounds(camera_, &least, &most, error_.Take());
    if (error_.Happened()) return Refused("exposure_us");
    if (*settings_.exposure_us < least || *settings_.exposure_us > most) {
      return Refuse(ErrorCode::kBadInput, "exposure_us is {}, this camera allows {} to {}", *settings_.exposure_us,
                    least, most);
    }
    arv_camera_set_exposure_time(camera_, *settings_.exposure_us, error_.Take());
    if (error_.Happened()) return Refused("exposure_us");
    return {};
  }

  Result<void> SetGain() {
    if (!settings_.gain_db) return {};
    if (arv_camera_is_gain_available(camera_, error_.Take()) == FALSE) {
      return Refuse(ErrorCode::kUnsupported, "gain_db is {}, this camera has no gain", *settings_.gain_db);
    }
    if (arv_camera_is_gain_auto_available(camera_, error_.Take()) != FALSE) {
      arv_camera_set_gain_auto(camera_, ARV_AUTO_OFF, error_.Take());
    }
    double least = 0, most = 0;
    arv_camera_get_gain_bounds(camera_, &least, &most, error_.Take());
    if (error_.Happened()) return Refused("gain_db");
    if (*settings_.gain_db < least || *settings_.gain_db > most) {
      return Refuse(ErrorCode::kBadInput, "gain_db is {}, this camera allows {} to {}", *settings_.gain_db, least,
                    most);
    }
    arv_camera_set_gain(camera_, *settings_.gain_db, error_.Take());
    if (error_.Happened()) return Refused("gain_db");
    return {};
  }

  /// The line of a hardware trigger: the one that the camera has chosen, or its first.
  std::string TriggerLine() {
    const char* chosen = arv_camera_get_trigger_source(camera_, error_.Take());
    constexpr std::string_view kLine = "Line";
    if (chosen != nullptr && std::string_view(chosen).starts_with(kLine)) return chosen;
    guint count = 0;
    const char** names = arv_camera_dup_available_trigger_sources(camera_, &count, error_.Take());
    const std::vector<std::string> sources(names, names + count);
    g_free(names);
    const auto line = std::ranges::find_if(sources, [&](const std::string& name) { return name.starts_with(kLine); });
    return line == sources.end() ? "" : *line;
  }

  Result<void> SetTrigger() {
    arv_camera_set_acquisition_mode(camera_, ARV_ACQUISITION_MODE_CONTINUOUS, error_.Take());
    if (error_.Happened()) return Refused("continuous acquisition");
    const bool software = settings_.trigger == CameraTrigger::kSoftware;
    if (software && arv_camera_is_software_trigger_supported(camera_, error_.Take()) == FALSE) {
      return Refuse(ErrorCode::kUnsupported, "trigger is \"software\", this camera has only lines to be triggered by");
    }
    const std::string source = software ? "Software" : TriggerLine();
    if (source.empty()) {
      return Refuse(ErrorCode::kUnsupported, "trigger is \"hardware\", this camera has no line to be triggered by");
    }
    arv_camera_set_trigger(camera_, source.c_str(), error_.Take());
    if (error_.Happened()) return Refused("trigger");
    return {};
  }

  Result<void> SetPacketSize() {
    if (arv_camera_is_gv_device(camera_) == FALSE) return {};
    arv_camera_gv_set_packet_size_adjustment(camera_, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);  // once is here
    if (settings_.packet_bytes) return SetWhole("packet_bytes", "GevSCPSPacketSize", *settings_.packet_bytes);
    arv_camera_gv_auto_packet_size(camera_, error_.Take());
    if (error_.Happened()) return Refused("to negotiate packet_bytes");
    return {};
  }

  Result<CameraFacts> Facts() {
    CameraFacts facts;
    gint left_px = 0, top_px = 0;
    arv_camera_get_region(camera_, &left_px, &top_px, &facts.width_px, &facts.height_px, error_.Take());
    if (error_.Happened()) return Refused("to tell its picture size");
    facts.payload_bytes = arv_camera_get_payload(camera_, error_.Take());
    if (error_.Happened()) return Refused("to tell its payload size");
    if (Has("Gamma") && (!Has("GammaEnable") || arv_camera_get_boolean(camera_, "GammaEnable", error_.Take()))) {
      const double gamma = arv_camera_get_float(camera_, "Gamma", error_.Take());
      facts.linear = error_.Happened() || std::abs(gamma - kGammaOff) < kGammaTolerance;
    }
    ArvDevice* device = arv_camera_get_device(camera_);
    facts.has_clock = ARV_IS_GV_DEVICE(device) &&
                      arv_gv_device_get_timestamp_tick_frequency(ARV_GV_DEVICE(device), error_.Take()) != 0;
    return facts;
  }

  ArvCamera* camera_;
  const CameraSettings& settings_;
  GLibError error_;
};

}  // namespace

Result<CameraFacts> SetUpCamera(ArvCamera* camera, const CameraSettings& settings) {
  return Setup(camera, settings).All();
}

}  // namespace rigcal
