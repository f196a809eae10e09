#pragma once

#include <nlohmann/json.hpp>

#include "daemon/jobs/job_queue.h"

namespace rigcal {

/// A job as replies and events show it (docs/openapi.json, Job).
nlohmann::ordered_json JobJson(const JobStatus& status);

}  // namespace rigcal
