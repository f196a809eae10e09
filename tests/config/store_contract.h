#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <barrier>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <thread>

#include "config/read_file.h"
#include "tests/config/example_revision.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {

/// A kind of store. `open` gives a connection to the store that lives in the folder, and makes it at first; `reopen`
/// opens what Backup has written.
struct StoreKind {
  std::string name;
  std::function<Result<std::unique_ptr<CalibrationStore>>(const std::filesystem::path& folder)> open;
  std::function<Result<std::unique_ptr<CalibrationStore>>(const std::filesystem::path& file)> reopen;
};

inline void PrintTo(const StoreKind& kind, std::ostream* out) {
  *out << kind.name;
}

/// What every CalibrationStore does. Another store: INSTANTIATE_TEST_SUITE_P with its StoreKind.
class StoreContract : public ::testing::TestWithParam<StoreKind> {
 protected:
  using Store = std::unique_ptr<CalibrationStore>;

  void SetUp() override { store_ = Open(); }

  Store Open() const {
    auto opened = GetParam().open(folder_.Path());
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().message);
    return opened ? std::move(*opened) : nullptr;
  }

  int Append(int variant, Verdict verdict = Verdict::kAccepted, const std::string& rig = "studio") {
    const auto number = store_->Append(ExampleRevision(rig, variant, verdict));
    EXPECT_TRUE(number) << (number ? "" : number.error().message);
    return number.value_or(-1);
  }

  Result<PublishEvent> Publish(int revision, std::optional<int> expected) {
    return store_->Publish(ExampleRequest("studio", revision, expected));
  }

  Result<PublishEvent> RollBack(int revision, int expected) {
    PublishRequest request = ExampleRequest("studio", revision, expected);
    request.kind = PublishKind::kRollback;
    return store_->Publish(request);
  }

  /// The number in force; 0 for none.
  static int InForce(CalibrationStore& store, const std::string& rig = "studio") {
    const auto event = store.InForce(rig);
    EXPECT_TRUE(event);
    return event && *event ? (*event)->revision : 0;
  }

  std::size_t NumEvents() { return store_->History("studio")->events.size(); }

  TemporaryFolder folder_;
  Store store_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(StoreContract);

inline void ExpectRefused(const Result<PublishEvent>& refused, const std::vector<std::string>& words,
                          ErrorCode code = ErrorCode::kBadInput) {
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, code);
  for (const std::string& word : words) EXPECT_THAT(refused.error().message, ::testing::HasSubstr(word));
}

inline void ExpectSame(const CalibrationRevision& stored, const CalibrationRevision& given) {
  EXPECT_EQ(stored.calibration_text, given.calibration_text);
  EXPECT_EQ(stored.report_text, given.report_text);
  EXPECT_EQ(stored.head.rig, given.head.rig);
  EXPECT_EQ(stored.head.time, given.head.time);
  EXPECT_EQ(stored.head.verdict, given.head.verdict);
  EXPECT_EQ(stored.head.reasons, given.head.reasons);
  EXPECT_EQ(stored.head.calibration_sha256, Sha256Hex(given.calibration_text));
  const RevisionOrigin &a = stored.head.origin, &b = given.head.origin;
  EXPECT_EQ(a.recording_id, b.recording_id);
  EXPECT_EQ(a.recording_sha256, b.recording_sha256);
  EXPECT_EQ(a.seed_revision, b.seed_revision);
  EXPECT_EQ(a.run.program_version, b.run.program_version);
  EXPECT_EQ(a.run.method, b.run.method);
  EXPECT_EQ(a.run.options, b.run.options);
  EXPECT_EQ(a.run.random_seed, b.run.random_seed);
  EXPECT_EQ(a.run.notes, b.run.notes);
  ASSERT_EQ(a.run.inputs.size(), b.run.inputs.size());
  for (std::size_t i = 0; i < b.run.inputs.size(); ++i) {
    EXPECT_EQ(a.run.inputs[i].name, b.run.inputs[i].name);
    EXPECT_EQ(a.run.inputs[i].sha256, b.run.inputs[i].sha256);
  }
}

TEST_P(StoreContract, KnowsTheRecordingsOfAllRigs) {
  EXPECT_TRUE(RecordingsOfRevisions(*store_)->empty());
  CalibrationRevision unknown = ExampleRevision("other", 2);
  unknown.head.origin.recording_id.clear();
  unknown.head.origin.recording_sha256 = std::string(64, 'c');
  ASSERT_TRUE(store_->Append(unknown));
  Append(1);
  unknown.head.origin.recording_sha256.clear();  // pictures that were no recording
  ASSERT_TRUE(store_->Append(unknown));
  EXPECT_THAT(*RecordingsOfRevisions(*store_),
              ::testing::UnorderedElementsAre("night 1", std::string(64, 'a'), std::string(64, 'c')));
}

TEST_P(StoreContract, KeepsEveryFieldForAnotherConnection) {
  const int first = Append(1);
  CalibrationRevision given = ExampleRevision("studio", 2, Verdict::kRejected);
  given.head.origin.seed_revision = first;
  given.head.number = 77;  // not looked at
  const auto number = store_->Append(given);
  ASSERT_TRUE(number) << number.error().message;
  EXPECT_GT(*number, first);
  const Store other = Open();
  const auto stored = other->Load("studio", *number);
  ASSERT_TRUE(stored) << stored.error().message;
  ExpectSame(*stored, given);
  EXPECT_EQ(stored->head.number, *number);
  EXPECT_EQ(stored->head.parent, std::nullopt);
  EXPECT_EQ(other->History("studio")->revisions.size(), 2U);
}

TEST_P(StoreContract, SaysWhatIsNotThere) {
  const int number = Append(1);
  const auto missing = store_->Load("studio", number + 1);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  const auto of_other_rig = store_->Load("other", number);
  ASSERT_FALSE(of_other_rig);
  EXPECT_EQ(of_other_rig.error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(store_->History("other")->revisions.empty());
  EXPECT_EQ(InForce(*store_, "other"), 0);
  const auto published = Publish(number + 1, {});
  ASSERT_FALSE(published);
  EXPECT_EQ(published.error().code, ErrorCode::kNotFound);
}

TEST_P(StoreContract, RefusesWhatIsNoRevision) {
  const auto refused = [this](const auto& spoil, const char* word) {
    CalibrationRevision revision = ExampleRevision("studio", 1);
    spoil(revision);
    const auto number = store_->Append(revision);
    ASSERT_FALSE(number) << word;
    EXPECT_THAT(number.error().message, ::testing::HasSubstr(word));
  };
  refused([](auto& r) { r.head.rig = "a/b"; }, "'a/b' names no rig");
  refused([](auto& r) { r.head.rig = ""; }, "names no rig");
  refused([](auto& r) { r.calibration_text.resize(r.calibration_text.size() / 2); }, "calibration");
  refused([](auto& r) { r.report_text = "{"; }, "report");
  refused([](auto& r) { r.head.verdict = Verdict::kRejected; }, "rejected with 0 reasons");
  refused([](auto& r) { r.head.reasons = {"why"}; }, "accepted with 1 reasons");
  refused([](auto& r) { r.head.origin.seed_revision = 99; }, "99");
  refused([](auto& r) { r.head.time = "yesterday"; }, "storing a revision was refused");
  EXPECT_TRUE(store_->History("studio")->revisions.empty());
}

TEST_P(StoreContract, PublishingMovesThePointerAndIsKept) {
  const int a = Append(1), b = Append(2);
  ASSERT_TRUE(Publish(a, {}));
  EXPECT_EQ(InForce(*store_), a);
  EXPECT_EQ(store_->Load("studio", Append(3))->head.parent, a);
  ASSERT_TRUE(Publish(b, a));
  const Store other = Open();
  EXPECT_EQ(InForce(*other), b);
  const auto events = other->History("studio")->events;
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].previous, std::nullopt);
  EXPECT_EQ(events[1].previous, a);
  EXPECT_EQ(events[1].revision, b);
  EXPECT_EQ(events[1].by, "anna");
  EXPECT_EQ(events[1].time, "2026-02-01T06:00:00Z");
  EXPECT_EQ(events[1].kind, PublishKind::kPublish);
  EXPECT_GT(events[1].number, events[0].number);
}

TEST_P(StoreContract, AnotherThanExpectedIsRefusedByName) {
  const int a = Append(1), b = Append(2), c = Append(3);
  ExpectRefused(Publish(a, b), {"no revision is in force, not 2 as expected"}, ErrorCode::kConflict);
  ASSERT_TRUE(Publish(a, {}));
  ExpectRefused(Publish(c, b), {"revision 1 is in force, not 2 as expected", "by anna at 2026-02-01T06:00:00Z"},
                ErrorCode::kConflict);
  ExpectRefused(Publish(c, {}), {"revision 1 is in force, not none as expected"}, ErrorCode::kConflict);
  ExpectRefused(Publish(a, a), {"revision 1 is in force already"}, ErrorCode::kConflict);
  EXPECT_EQ(InForce(*store_), a);
  EXPECT_EQ(NumEvents(), 1U);
}

TEST_P(StoreContract, WhatWasNotAcceptedNeedsAReasonWhichIsKept) {
  for (const Verdict verdict : {Verdict::kRejected, Verdict::kInconclusive}) {
    const int before = InForce(*store_);
    const std::optional<int> expected = before == 0 ? std::nullopt : std::optional(before);
    const int number = Append(static_cast<int>(verdict), verdict);
    EXPECT_EQ(InForce(*store_), before);
    ExpectRefused(Publish(number, expected), {"epipolar: 1.3 px", "with a reason"});
    PublishRequest request = ExampleRequest("studio", number, expected);
    request.reason = "checked by hand";
    ASSERT_TRUE(store_->Publish(request));
    EXPECT_EQ(store_->History("studio")->events.back().reason, "checked by hand");
  }
  PublishRequest nobody = ExampleRequest("studio", Append(3), InForce(*store_));
  nobody.by = "";
  EXPECT_FALSE(store_->Publish(nobody));
}

TEST_P(StoreContract, RollBackIsAnEventAndTwoGoBackTwoSteps) {
  const int a = Append(1), b = Append(2, Verdict::kRejected), c = Append(3), never = Append(4);
  ASSERT_TRUE(Publish(a, {}));
  PublishRequest forced = ExampleRequest("studio", b, a);
  forced.reason = "checked by hand";
  ASSERT_TRUE(store_->Publish(forced));
  ASSERT_TRUE(Publish(c, b));
  ExpectRefused(RollBack(never, c), {"revision 4 was never in force"});
  const auto before = [this] { return RevisionBefore(store_->History("studio")->events); };
  EXPECT_EQ(before(), b);
  ASSERT_TRUE(RollBack(b, c));  // it was in force with a reason: going back to it needs none
  EXPECT_EQ(InForce(*store_), b);
  EXPECT_EQ(before(), a);
  ASSERT_TRUE(RollBack(a, b));
  EXPECT_EQ(before(), std::nullopt);
  ASSERT_TRUE(Publish(c, a));
  EXPECT_EQ(before(), a);
  EXPECT_EQ(NumEvents(), 6U);
  EXPECT_EQ(store_->History("studio")->events[3].kind, PublishKind::kRollback);
}

TEST_P(StoreContract, RigsHaveTheirOwnPointers) {
  const int a = Append(1, Verdict::kAccepted, "left"), b = Append(2, Verdict::kAccepted, "right");
  ASSERT_TRUE(store_->Publish(ExampleRequest("left", a, {})));
  ASSERT_TRUE(store_->Publish(ExampleRequest("right", b, {})));
  EXPECT_EQ(InForce(*store_, "left"), a);
  EXPECT_EQ(InForce(*store_, "right"), b);
  EXPECT_EQ(*store_->Rigs(), (std::vector<std::string>{"left", "right"}));
  const auto crossed = store_->Publish(ExampleRequest("left", b, a));
  ASSERT_FALSE(crossed);
  EXPECT_EQ(crossed.error().code, ErrorCode::kNotFound);
}

TEST_P(StoreContract, OfTwoThatPublishAtOnceExactlyOneWins) {
  constexpr int kRounds = 50;
  std::optional<int> in_force;
  const std::array<Store, 2> clients = {Open(), Open()};
  for (int round = 0; round < kRounds; ++round) {
    const std::array<int, 2> wanted = {Append(2 * round), Append(2 * round + 1)};
    std::array<Result<PublishEvent>, 2> outcome;
    std::barrier start(2);
    const auto publish = [&](std::size_t client) {
      start.arrive_and_wait();
      outcome[client] = clients[client]->Publish(ExampleRequest("studio", wanted[client], in_force));
    };
    std::thread other(publish, 1);
    publish(0);
    other.join();
    ASSERT_EQ(outcome[0].has_value() + outcome[1].has_value(), 1) << "round " << round;
    const std::size_t winner = outcome[0] ? 0 : 1;
    EXPECT_THAT(outcome[1 - winner].error().message,
                ::testing::HasSubstr(fmt::format("revision {} is in force, not", wanted[winner])));
    in_force = InForce(*store_);
    EXPECT_EQ(in_force, wanted[winner]);
  }
  EXPECT_EQ(NumEvents(), static_cast<std::size_t>(kRounds));
  EXPECT_TRUE(store_->Check({})->empty());
}

TEST_P(StoreContract, BackupHoldsAllAndOverwritesNothing) {
  const int a = Append(1);
  ASSERT_TRUE(Publish(a, {}));
  const auto file = folder_.Path() / "copies" / "backup";
  EXPECT_FALSE(store_->Backup(file)) << "its folder is missing";
  std::filesystem::create_directory(file.parent_path());
  const auto written = store_->Backup(file);
  ASSERT_TRUE(written) << written.error().message;
  Append(2);
  const auto copy = GetParam().reopen(file);
  ASSERT_TRUE(copy) << copy.error().message;
  EXPECT_EQ(InForce(**copy), a);
  EXPECT_EQ((*copy)->History("studio")->revisions.size(), 1U);
  EXPECT_TRUE((*copy)->Check({})->empty());
  const std::string bytes = *ReadFile(file);
  const auto again = store_->Backup(file);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kBadInput);
  EXPECT_EQ(*ReadFile(file), bytes);
}

TEST_P(StoreContract, CheckFindsNothingWrongAndCanBeStopped) {
  ASSERT_TRUE(Publish(Append(1), {}));
  const auto findings = store_->Check({});
  ASSERT_TRUE(findings);
  EXPECT_THAT(*findings, ::testing::IsEmpty());
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = store_->Check(stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
}

}  // namespace rigcal
