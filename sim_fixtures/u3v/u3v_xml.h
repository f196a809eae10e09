#pragma once

#include <string>

namespace rigcal::sim {

/// The camera's description in GenICam's language: its features and the registers (u3v_registers.h) behind them.
std::string U3vXml();

}  // namespace rigcal::sim
