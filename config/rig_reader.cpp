#include "config/rig_reader.h"

#include <algorithm>

#include "config/rig_key_hints.h"
#include "core/base/ensure.h"
#include "core/base/joined.h"

namespace rigcal {
namespace {

NumberRange RangeOf(const RigKey& key) {
  const bool whole = key.type == KeyType::kWhole || key.type == KeyType::kWholes;
  return {key.least, key.most, whole, key.unit.words};
}

bool IsNameCharacter(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' || c == '_';
}

bool IsText(const toml::node& node, const RigKey& key) {
  if (!node.is_string()) return false;
  const std::string& text = node.ref<std::string>();
  if (key.type == KeyType::kWord) return std::ranges::find(key.words, text) != key.words.end();
  const bool name = key.type == KeyType::kName;
  const std::size_t longest = name ? kMaxNameLength : kMaxTextLength;
  return !text.empty() && text.size() <= longest && (!name || std::ranges::all_of(text, IsNameCharacter));
}

Result<void> CheckNumbers(const toml::array& list, const RigKey& key, const std::string& file) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const toml::node& node = list[i];
    if (key.type == KeyType::kNumberRows) {
      const toml::array* row = node.as_array();
      if (row == nullptr)
        return Fail(ErrorCode::kBadInput, "{} must be {}", KeyPlace(file, node, key.name), KeyDescription(key));
      RigKey inner = key;
      inner.type = KeyType::kNumbers;
      if (auto checked = CheckNumbers(*row, inner, file); !checked) return checked;
      continue;
    }
    const auto number = TomlNumber(node, KeyPlace(file, node, fmt::format("{}[{}]", key.name, i)), RangeOf(key));
    if (!number) return Fail(number.error());
  }
  return {};
}

Result<void> CheckTexts(const toml::array& list, const std::string& where) {
  std::vector<std::string> texts;
  for (const toml::node& node : list) {
    if (!IsText(node, {}) || std::ranges::find(texts, node.ref<std::string>()) != texts.end())
      return Fail(ErrorCode::kBadInput, "{} must be different names in quotes", where);
    texts.push_back(node.ref<std::string>());
  }
  return {};
}

Result<void> CheckList(const toml::node& node, const RigKey& key, const std::string& file) {
  const std::string where = KeyPlace(file, node, key.name);
  const toml::array* list = node.as_array();
  const int length = list == nullptr ? -1 : static_cast<int>(list->size());
  if (length < key.fewest || length > key.longest)
    return Fail(ErrorCode::kBadInput, "{} must be {}", where, KeyDescription(key));
  return key.type == KeyType::kTexts ? CheckTexts(*list, where) : CheckNumbers(*list, key, file);
}

}  // namespace

Result<void> CheckRigValue(const toml::node& node, const RigKey& key, const std::string& file) {
  switch (key.type) {
    case KeyType::kNumber:
    case KeyType::kWhole: {
      const Result<double> number = TomlNumber(node, KeyPlace(file, node, key.name), RangeOf(key));
      return number ? Result<void>() : Fail(number.error());
    }
    case KeyType::kNumbers:
    case KeyType::kWholes:
    case KeyType::kNumberRows:
    case KeyType::kTexts:
      return CheckList(node, key, file);
    case KeyType::kText:
    case KeyType::kName:
    case KeyType::kWord:
      if (IsText(node, key)) return {};
      break;
    case KeyType::kFlag:
      if (node.is_boolean()) return {};
      break;
  }
  return Fail(ErrorCode::kBadInput, "{} must be {}", KeyPlace(file, node, key.name), KeyDescription(key));
}

Result<void> CheckRigTables(const toml::table& document, const std::string& file) {
  for (const auto& [name, node] : document) {
    const auto tables = RigTables();
    const auto found = std::ranges::find(tables, name.str(), &RigTable::name);
    if (found == tables.end()) {
      std::vector<std::string> known;
      for (const RigTable& table : tables) known.push_back(table.Title());
      return Fail(ErrorCode::kBadInput, "{}: unknown in a rig file; known are {}", KeyPlace(file, node, name.str()),
                  Joined(known, ", "));
    }
    if (found->repeated ? !node.is_array_of_tables() : !node.is_table())
      return Fail(ErrorCode::kBadInput, "{} must be a table, {}", KeyPlace(file, node, name.str()), found->Title());
  }
  return {};
}

Result<CheckedTable> CheckedTable::Check(const toml::table& table, const RigTable& schema, const std::string& file,
                                         const std::string& kind, const std::vector<std::string>& inner) {
  for (const auto& [name, node] : table) {
    if (std::ranges::find(inner, name.str()) != inner.end()) continue;
    const RigKey* key = schema.Find(name.str(), kind);
    if (key == nullptr)
      return Fail(ErrorCode::kBadInput, "{}: {}", KeyPlace(file, node, name.str()),
                  WhyUnknown(name.str(), schema, kind));
    if (auto checked = CheckRigValue(node, *key, file); !checked) return Fail(checked.error());
  }
  for (const RigKey& key : schema.keys) {
    if (key.fallback != kRequired || !key.IsOf(kind) || table.contains(key.name)) continue;
    return Fail(ErrorCode::kBadInput, "{} line {}: {}.{} is missing, {}", file, table.source().begin.line, schema.name,
                key.name, KeyDescription(key));
  }
  return CheckedTable(table, schema, file, kind);
}

Result<std::optional<CheckedTable>> CheckedSection(const toml::table& document, std::string_view name,
                                                   const std::string& file, const std::string& kind) {
  const toml::table* table = document[name].as_table();
  if (table == nullptr) return std::optional<CheckedTable>();
  Result<CheckedTable> checked = CheckedTable::Check(*table, RigTableNamed(name), file, kind);
  if (!checked) return Fail(checked.error());
  return std::optional(std::move(*checked));
}

Result<std::vector<CheckedTable>> CheckedSections(const toml::node* list, std::string_view name,
                                                  const std::string& file, const std::string& kind) {
  std::vector<CheckedTable> sections;
  if (list == nullptr) return sections;
  const RigTable& schema = RigTableNamed(name);
  if (!list->is_array_of_tables())
    return Fail(ErrorCode::kBadInput, "{} must be a table, {}", KeyPlace(file, *list, name), schema.Title());
  for (const toml::node& node : *list->as_array()) {
    Result<CheckedTable> checked = CheckedTable::Check(*node.as_table(), schema, file, kind);
    if (!checked) return Fail(checked.error());
    sections.push_back(std::move(*checked));
  }
  return sections;
}

std::string CheckedTable::Place(std::string_view key) const {
  const toml::node* node = table_->get(key);
  return KeyPlace(file_, node == nullptr ? *table_ : *node, key);
}

const toml::node* CheckedTable::Find(std::string_view key) const {
  const auto has = [&](const RigKey& row) { return row.name == key; };
  Ensure(std::ranges::any_of(schema_->keys, has), "a key that is read has a row in the schema");
  return table_->get(key);
}

std::optional<double> CheckedTable::Number(std::string_view key) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return std::nullopt;
  return node->value<double>().value() * schema_->Find(key, kind_)->unit.to_si;
}

void CheckedTable::Read(std::string_view key, double& value) const {
  value = Number(key).value_or(value);
}

void CheckedTable::Read(std::string_view key, std::optional<double>& value) const {
  if (const auto number = Number(key)) value = number;
}

void CheckedTable::Read(std::string_view key, int& value) const {
  if (const auto number = Number(key)) value = static_cast<int>(*number);
}

void CheckedTable::Read(std::string_view key, std::optional<int>& value) const {
  if (const auto number = Number(key)) value = static_cast<int>(*number);
}

void CheckedTable::Read(std::string_view key, std::uint64_t& value) const {
  if (const auto number = Number(key)) value = static_cast<std::uint64_t>(*number);
}

void CheckedTable::Read(std::string_view key, bool& value) const {
  if (const toml::node* node = Find(key)) value = node->ref<bool>();
}

void CheckedTable::Read(std::string_view key, std::string& value) const {
  if (const toml::node* node = Find(key)) value = node->ref<std::string>();
}

void CheckedTable::Read(std::string_view key, std::vector<std::string>& value) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return;
  value.clear();
  for (const toml::node& text : *node->as_array()) value.push_back(text.ref<std::string>());
}

namespace {

std::vector<double> NumbersOf(const toml::array& list, double to_si) {
  std::vector<double> numbers;
  for (const toml::node& node : list) numbers.push_back(node.value<double>().value() * to_si);
  return numbers;
}

}  // namespace

void CheckedTable::Read(std::string_view key, std::vector<double>& value) const {
  const toml::node* node = Find(key);
  if (node != nullptr) value = NumbersOf(*node->as_array(), schema_->Find(key, kind_)->unit.to_si);
}

void CheckedTable::Read(std::string_view key, std::vector<std::vector<double>>& value) const {
  const toml::node* node = Find(key);
  if (node == nullptr) return;
  value.clear();
  for (const toml::node& row : *node->as_array())
    value.push_back(NumbersOf(*row.as_array(), schema_->Find(key, kind_)->unit.to_si));
}

}  // namespace rigcal
