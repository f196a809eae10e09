#include "tests/config/schema_check.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

namespace rigcal {

std::string SchemaComplaints(const std::string& schema_name, const std::string& text) {
  std::ifstream file(std::string(RIGCAL_SCHEMA_DIR) + "/" + schema_name);
  const nlohmann::json schema_json = nlohmann::json::parse(file), document = nlohmann::json::parse(text);
  valijson::Schema schema;
  valijson::SchemaParser(valijson::SchemaParser::kDraft7)
      .populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_json), schema);
  valijson::ValidationResults results;
  std::string complaints;
  valijson::Validator().validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results);
  for (valijson::ValidationResults::Error error; results.popError(error);) {
    for (const std::string& key : error.context) complaints += key;
    complaints += ": " + error.description + "\n";
  }
  return complaints;
}

}  // namespace rigcal
