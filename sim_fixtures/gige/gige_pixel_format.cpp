#include "sim_fixtures/gige/gige_pixel_format.h"

#include <algorithm>
#include <array>

namespace rigcal::sim {
namespace {

constexpr std::array kFormats = {
    GigePixelFormat{"Mono8", 0x01080001, 8},      GigePixelFormat{"Mono10", 0x01100003, 10},
    GigePixelFormat{"Mono12", 0x01100005, 12},    GigePixelFormat{"Mono16", 0x01100007, 16},
    GigePixelFormat{"BayerGR8", 0x01080008, 8},   GigePixelFormat{"BayerRG8", 0x01080009, 8},
    GigePixelFormat{"BayerGB8", 0x0108000a, 8},   GigePixelFormat{"BayerBG8", 0x0108000b, 8},
    GigePixelFormat{"BayerGR12", 0x01100010, 12}, GigePixelFormat{"BayerRG12", 0x01100011, 12},
    GigePixelFormat{"BayerGB12", 0x01100012, 12}, GigePixelFormat{"BayerBG12", 0x01100013, 12},
};

}  // namespace

std::span<const GigePixelFormat> GigePixelFormats() {
  return kFormats;
}

std::optional<GigePixelFormat> FindGigePixelFormat(std::uint32_t code) {
  const auto found = std::ranges::find(kFormats, code, &GigePixelFormat::code);
  if (found == kFormats.end()) return std::nullopt;
  return *found;
}

}  // namespace rigcal::sim
