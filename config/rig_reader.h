#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/rig_keys.h"
#include "config/toml_content.h"
#include "core/base/result.h"

namespace rigcal {

/// A table of a rig file whose every key was checked against its rows, so that reading cannot fail. Lives no longer
/// than its document.
class CheckedTable {
 public:
  /// `kind` is the positioner's word. `inner` are the names of tables below it, which are no keys of it. Errors:
  /// kBadInput with file, line, key and what is allowed: a key that is unknown (another unit is told as such), not of
  /// this kind, missing, of another type, out of range, or not one of its words.
  static Result<CheckedTable> Check(const toml::table& table, const RigTable& schema, const std::string& file,
                                    const std::string& kind, const std::vector<std::string>& inner = {});

  [[nodiscard]] bool Has(std::string_view key) const { return table_->contains(key); }
  /// "FILE line N: KEY"; the line of the table where the key is not there.
  [[nodiscard]] std::string Place(std::string_view key) const;
  [[nodiscard]] const std::string& File() const { return file_; }
  [[nodiscard]] std::size_t Line() const { return table_->source().begin.line; }

  // The value as the program holds it (KeyUnit::to_si); left as it is when the key is not there. Asking a table for a
  // key that its schema does not have is a bug.
  void Read(std::string_view key, double& value) const;
  void Read(std::string_view key, std::optional<double>& value) const;
  void Read(std::string_view key, int& value) const;
  void Read(std::string_view key, std::optional<int>& value) const;
  void Read(std::string_view key, std::uint64_t& value) const;
  void Read(std::string_view key, bool& value) const;
  void Read(std::string_view key, std::string& value) const;
  void Read(std::string_view key, std::vector<std::string>& value) const;
  void Read(std::string_view key, std::vector<double>& value) const;
  void Read(std::string_view key, std::vector<std::vector<double>>& value) const;

 private:
  CheckedTable(const toml::table& table, const RigTable& schema, std::string file, std::string kind)
      : table_(&table), schema_(&schema), file_(std::move(file)), kind_(std::move(kind)) {}
  /// Nothing when it is not there.
  [[nodiscard]] const toml::node* Find(std::string_view key) const;
  [[nodiscard]] std::optional<double> Number(std::string_view key) const;

  const toml::table* table_;
  const RigTable* schema_;
  std::string file_, kind_;
};

/// The table of this name when the document has it. Errors: those of CheckedTable::Check.
Result<std::optional<CheckedTable>> CheckedSection(const toml::table& document, std::string_view name,
                                                   const std::string& file, const std::string& kind);

/// All tables [[`name`]] of a list; none when there is no list. Errors: those of CheckedTable::Check; kBadInput when
/// `list` is something else.
Result<std::vector<CheckedTable>> CheckedSections(const toml::node* list, std::string_view name,
                                                  const std::string& file, const std::string& kind);

/// One key alone. Errors: as CheckedTable::Check for it.
Result<void> CheckRigValue(const toml::node& node, const RigKey& key, const std::string& file);

/// Errors: kBadInput: something in the file that is no table of RigTables(), or not written as one ("[[camera]]").
Result<void> CheckRigTables(const toml::table& document, const std::string& file);

}  // namespace rigcal
