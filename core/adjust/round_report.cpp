#include "core/adjust/round_report.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

constexpr double kExpectedErrorSigmas = 3;  ///< paper section 3.3: Er = mean + 3 standard deviations

struct Moments {
  double sum = 0, sum_squares = 0;
  int count = 0;
  void Add(double x) { sum += x, sum_squares += x * x, ++count; }
  [[nodiscard]] double Mean() const { return count > 0 ? sum / count : 0; }
  [[nodiscard]] double Deviation() const {
    return count > 0 ? std::sqrt(std::max(0.0, sum_squares / count - Mean() * Mean())) : 0;
  }
  [[nodiscard]] double ExpectedError() const { return Mean() + kExpectedErrorSigmas * Deviation(); }
};

}  // namespace

void ReportFit(const FitResiduals& residuals, const MeasurementSet& measurements,
               const std::vector<double>& expected_error_px, const AdjustOptions& options, AdjustReport& report) {
  Moments all;
  std::vector<Moments> views(expected_error_px.size());
  for (std::size_t i = 0; i < measurements.items.size(); ++i) {
    all.Add(residuals.px[i]);
    views[measurements.items[i].view].Add(residuals.px[i]);
  }
  report.num_tracks = static_cast<int>(measurements.x_in_world.size());
  report.num_observations = all.count;
  report.reprojection_mean_px = all.Mean();
  report.reprojection_std_px = all.Deviation();
  for (std::size_t v = 0; v < views.size(); ++v) {
    report.residual_px.push_back(views[v].Mean());
    report.num_features.push_back(views[v].count);
    const bool enough = views[v].count >= options.min_features_per_view;
    const double found_px = std::max(options.min_expected_error_px, views[v].ExpectedError());
    const double bounded_px = enough ? std::min(expected_error_px[v], found_px) : expected_error_px[v];
    report.expected_error_px.push_back(options.paper ? all.ExpectedError() : bounded_px);
  }
}

}  // namespace rigcal
