#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "config/provenance.h"
#include "core/base/result.h"
#include "core/validate/validate.h"

namespace rigcal {

/// What it takes to repeat a revision.
struct RevisionOrigin {
  std::string recording_id;          ///< empty: not known
  std::string recording_sha256;      ///< of its recording.json; empty: the pictures were no recording
  std::optional<int> seed_revision;  ///< whose cameras the run began with; nothing: they came from elsewhere
  Provenance run;                    ///< program version, method, options, random seed, SHA-256 of every input
};

/// Everything about a revision but its texts, as a history lists it.
struct RevisionHead {
  int number = 0;  ///< given by the store, rising; unique among all rigs of the store
  std::string rig;
  std::string time;  ///< when it was made: ISO 8601, UTC
  Verdict verdict = Verdict::kInconclusive;
  std::vector<std::string> reasons;  ///< sentences; empty exactly when accepted
  std::optional<int> parent;         ///< in force when it was stored; given by the store
  RevisionOrigin origin;
  std::string calibration_sha256;  ///< of the calibration's text; given by the store
};

/// A calibration as it came out, accepted or not. Never changes once it is in a store.
struct CalibrationRevision {
  RevisionHead head;
  std::string calibration_text;  ///< calibration.json, byte for byte
  std::string report_text;       ///< report.json, byte for byte
};

enum class PublishKind { kPublish, kRollback };

/// The pointer to the revision in force of a rig moved. The last event of a rig is the pointer.
struct PublishEvent {
  int number = 0;  ///< given by the store, rising
  std::string rig;
  std::string time;  ///< ISO 8601, UTC
  PublishKind kind = PublishKind::kPublish;
  int revision = 0;
  std::optional<int> previous;  ///< in force before; nothing: none was
  std::string by;               ///< person or service
  std::string reason;           ///< never empty where a revision that was not accepted is published
};

/// A wish to move the pointer. `expected` is what the asker believes to be in force: compare-and-swap.
struct PublishRequest {
  std::string rig;
  int revision = 0;
  std::optional<int> expected;
  PublishKind kind = PublishKind::kPublish;
  std::string time, by, reason;
};

/// The revisions and publish events of a rig, each oldest first, as they stood at one moment.
struct RigHistory {
  std::vector<RevisionHead> revisions;
  std::vector<PublishEvent> events;
};

/// Append-only store of calibrations and of which one is in force. An object belongs to one thread; any number of
/// objects and processes may have the same store open. Every store passes tests/config/store_contract.h. Errors of all:
/// kIo, kDiskFull and kTimeout (another held the store for too long), naming the store.
class CalibrationStore {
 public:
  CalibrationStore() = default;
  CalibrationStore(const CalibrationStore&) = delete;
  CalibrationStore& operator=(const CalibrationStore&) = delete;
  virtual ~CalibrationStore() = default;

  /// Keeps a revision, whole or not at all, and gives its number. What the store gives (number, parent, checksum) is
  /// not looked at in `revision`. Errors also: those of CheckRevision; kNotFound: head.origin.seed_revision.
  virtual Result<int> Append(const CalibrationRevision& revision) = 0;

  /// Moves the pointer of a rig and keeps that as an event. Errors also: kNotFound; those of CheckPublish.
  virtual Result<PublishEvent> Publish(const PublishRequest& request) = 0;

  /// Errors also: kNotFound: the rig has no such revision; kIo: it is not what was once stored.
  virtual Result<CalibrationRevision> Load(const std::string& rig, int number) = 0;

  /// Nothing when no revision of the rig was ever published.
  virtual Result<std::optional<PublishEvent>> InForce(const std::string& rig) = 0;

  /// Empty for a rig that the store does not know.
  virtual Result<RigHistory> History(const std::string& rig) = 0;

  /// Names of the rigs, sorted.
  virtual Result<std::vector<std::string>> Rigs() = 0;

  /// Writes all of it to a new file, from which a store can be opened, whole or not at all, while others go on. Errors
  /// also: kBadInput: the file is there already and is kept.
  virtual Result<void> Backup(const std::filesystem::path& file) = 0;

  /// What is wrong with the store, a sentence each; reads every byte. Errors also: kCancelled.
  virtual Result<std::vector<std::string>> Check(const std::stop_token& stop) = 0;
};

/// What every store asks of a revision. Errors: kBadInput: a rig's name that is empty, longer than 64 characters or has
/// others than letters, digits, '.', '_' and '-'; texts that are not those of a calibration and a report; reasons that
/// do not fit the verdict.
Result<void> CheckRevision(const CalibrationRevision& revision);

/// What every store asks before the pointer moves. `revision` is the one asked for, `events` are those of its rig.
/// Errors: kConflict: another revision is in force than expected (who published it and when is said), or the revision
/// is in force already; kBadInput: nobody publishes, text that is not UTF-8, it was not accepted and no reason is
/// given, or a roll-back to one that never was in force.
Result<void> CheckPublish(const PublishRequest& request, const RevisionHead& revision,
                          const std::vector<PublishEvent>& events);

/// Where a roll-back leads: one step back through what was published; a roll-back takes its steps away, so that two in
/// a row go back two. Nothing: there is nothing to go back to.
std::optional<int> RevisionBefore(const std::vector<PublishEvent>& events);

/// What Check finds in every store: revisions that cannot be read or parsed, events that do not follow from each other.
/// Errors: those of the store; kCancelled.
Result<std::vector<std::string>> CheckContent(CalibrationStore& store, const std::stop_token& stop);

/// What the revisions of all rigs were made from: the ids of recordings, and the SHA-256 of their recording.json, as
/// far as they are known. Errors: those of the store.
Result<std::set<std::string>> RecordingsOfRevisions(CalibrationStore& store);

/// "publish" or "rollback".
const char* NameOf(PublishKind kind);

}  // namespace rigcal
