#include "config/provenance_json.h"

#include "config/json_content.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json ProvenanceJson(const Provenance& provenance) {
  Json options = Json::object(), inputs = Json::array();
  for (const auto& [name, value] : provenance.options) options[name] = value;
  for (const InputFile& input : provenance.inputs) inputs.push_back({{"file", input.name}, {"sha256", input.sha256}});
  return {{"program", "rigcal"},           {"version", provenance.program_version}, {"method", provenance.method},
          {"options", std::move(options)}, {"random_seed", provenance.random_seed}, {"inputs", std::move(inputs)},
          {"notes", provenance.notes}};
}

Provenance ProvenanceFrom(const Json& json) {
  Provenance provenance;
  provenance.program_version = json.at("version").get<std::string>();
  provenance.method = json.at("method").get<std::string>();
  for (const auto& [name, value] : json.at("options").items())
    provenance.options.emplace_back(name, value.get<std::string>());
  provenance.random_seed = json.at("random_seed").get<std::uint64_t>();
  for (const Json& input : List(json, "inputs"))
    provenance.inputs.push_back({input.at("file").get<std::string>(), input.at("sha256").get<std::string>()});
  provenance.notes = json.at("notes").get<std::vector<std::string>>();
  return provenance;
}

}  // namespace rigcal
