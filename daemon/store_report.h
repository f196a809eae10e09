#pragma once

#include <string>

#include "config/calibration_store.h"

namespace rigcal {

/// A line for each revision, oldest first, the one in force marked; then the publish events.
std::string HistoryText(const RigHistory& history);
std::string HistoryJson(const RigHistory& history);

/// Everything about one revision but its texts. `events`: those of its rig; the ones that published it are told.
std::string RevisionText(const RevisionHead& head, const std::vector<PublishEvent>& events);
std::string RevisionJson(const RevisionHead& head, const std::vector<PublishEvent>& events);

/// "2026-02-01T06:00:00Z  revision 5 -> 7 by anna: checked by hand".
std::string EventText(const PublishEvent& event);

}  // namespace rigcal
