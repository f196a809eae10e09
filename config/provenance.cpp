#include "config/provenance.h"

namespace rigcal {

std::string_view ProgramVersion() {
  return RIGCAL_VERSION;
}

}  // namespace rigcal
