#include "daemon/api/api.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <exception>
#include <utility>

#include "daemon/api/job_json.h"

namespace rigcal {
namespace {

std::vector<std::string> Segments(std::string_view path) {
  std::vector<std::string> segments;
  while (!path.empty()) {
    path.remove_prefix(1);  // '/'
    const std::size_t end = std::min(path.find('/'), path.size());
    segments.emplace_back(path.substr(0, end));
    path.remove_prefix(end);
  }
  return segments;
}

/// What stands for the {...} of a pattern; nothing when the path is another.
std::optional<std::vector<std::string>> Match(std::string_view pattern, std::string_view path) {
  if (!path.starts_with('/')) return std::nullopt;
  const auto wanted = Segments(pattern), given = Segments(path);
  if (wanted.size() != given.size()) return std::nullopt;
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i].starts_with('{')) {
      parts.push_back(given[i]);
    } else if (wanted[i] != given[i]) {
      return std::nullopt;
    }
  }
  return parts;
}

}  // namespace

struct Api::Row {
  ApiRoute route;
  ApiReply (Api::*answer)(const ApiRequest&, const Parts&);
};

std::span<const Api::Row> Api::Rows() {
  // A fixed word stands before a {part} of the same place.
  static constexpr std::array<Row, 13> kRows = {{
      {{"GET", "/healthz"}, &Api::Health},
      {{"GET", "/metrics"}, &Api::Metrics},
      {{"GET", "/api/v1/status"}, &Api::Status},
      {{"GET", "/api/v1/jobs"}, &Api::ListJobs},
      {{"POST", "/api/v1/jobs"}, &Api::SubmitJob},
      {{"GET", "/api/v1/jobs/{id}"}, &Api::ShowJob},
      {{"POST", "/api/v1/jobs/{id}/cancel"}, &Api::CancelJob},
      {{"GET", "/api/v1/jobs/{id}/events"}, &Api::JobEvents},
      {{"GET", "/api/v1/calibrations"}, &Api::ListCalibrations},
      {{"GET", "/api/v1/calibrations/diff"}, &Api::DiffCalibrations},
      {{"POST", "/api/v1/calibrations/rollback"}, &Api::Rollback},
      {{"GET", "/api/v1/calibrations/{revision}"}, &Api::ShowCalibration},
      {{"POST", "/api/v1/calibrations/{revision}/publish"}, &Api::Publish},
  }};
  return kRows;
}

std::vector<ApiRoute> Api::Routes() {
  std::vector<ApiRoute> routes;
  for (const Row& row : Rows()) routes.push_back(row.route);
  return routes;
}

ApiReply Api::Answer(const ApiRequest& request) {
  bool path_is_known = false;
  try {
    for (const Row& row : Rows()) {
      const auto parts = Match(row.route.path, request.path);
      if (!parts) continue;
      path_is_known = true;
      if (row.route.method == request.method) return (this->*row.answer)(request, *parts);
    }
  } catch (const std::exception& bug) {
    return ErrorReply(kStatusInternal, "internal", bug.what());
  }
  if (path_is_known) {
    return ErrorReply(kStatusWrongMethod, "wrong_method", request.path + ": does not answer " + request.method);
  }
  return ErrorReply({ErrorCode::kNotFound, "there is no " + request.path});
}

void Api::CountEnded(const Job& job) {
  const std::lock_guard lock(ended_mutex_);
  ++num_ended_[{job.kind, NameOf(job.state)}];
}

}  // namespace rigcal
