#include "config/covariance_json.h"

#include <vector>

namespace rigcal {

using Json = nlohmann::ordered_json;

Json CovarianceJson(const Eigen::MatrixXd& joint, const char* order) {
  std::vector<int> rows;
  for (int row = 0; row < joint.rows(); ++row)
    if (joint(row, row) != 0) rows.push_back(row);
  Json upper = Json::array();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Json line = Json::array();
    for (std::size_t j = i; j < rows.size(); ++j) line.push_back(joint(rows[i], rows[j]));
    upper.push_back(std::move(line));
  }
  return {{"order", order}, {"rows", rows}, {"upper_triangle", std::move(upper)}};
}

Eigen::MatrixXd CovarianceFrom(const Json& json, Eigen::Index size) {
  std::vector<int> rows;
  for (const Json& row : List(json, "rows"))
    rows.push_back(
        WholeNumber(row, rows.empty() ? 0 : rows.back() + 1, static_cast<int>(size) - 1, "a covariance row"));
  const Json& upper = json.at("upper_triangle");
  if (upper.size() != rows.size())
    Refuse("covariance: {} rows are listed, the upper triangle has {}", rows.size(), upper.size());
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (upper.at(i).size() != rows.size() - i)
      Refuse("covariance: line {} of the upper triangle has {} numbers instead of {}", i, upper.at(i).size(),
             rows.size() - i);
    for (std::size_t j = i; j < rows.size(); ++j)
      joint(rows[i], rows[j]) = joint(rows[j], rows[i]) = upper.at(i).at(j - i).get<double>();
  }
  return joint;
}

}  // namespace rigcal
