#pragma once

#include <string>

namespace rigcal::sim {

/// Limits that the description tells and the device keeps.
struct GigeLimits {
  int packet_step_bytes = 4, least_packet_bytes = 576, most_packet_bytes = 16000;
  int region_step_px = 8;
  double least_exposure_us = 10, most_exposure_us = 1e6, least_gain_db = 0, most_gain_db = 24;
};

/// The device's description in GenICam's language: its features and the registers (gige_registers.h) behind them.
std::string GenicamXml(const GigeLimits& limits);

}  // namespace rigcal::sim
