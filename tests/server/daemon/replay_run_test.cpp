// Recorded and replayed: every wrench to the bit. Truth: the recording.
#include "server/daemon/replay_run.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <filesystem>

#include "tests/server/daemon/recorded_session.h"
#include "tests/server/recorder/sample_ticks.h"

namespace hapticd::test {
namespace {

/// The session under both clocks, recorded once.
struct Recorded {
  TemporaryFolder folder;
  Recorded() {
    record_session(path(true), true);
    record_session(path(false), false);
  }
  [[nodiscard]] std::string path(bool virtual_time) const {
    return folder.file(virtual_time ? "virtual.mcap" : "real.mcap");
  }
};

const Recorded& recorded() {
  static const Recorded session;
  return session;
}

/// What happened in a recording.
struct Happened {
  std::uint64_t contacts = 0;  ///< ticks with force
  bool fault = false;
  bool second_scene = false;
  bool skipped = false;
  std::uint64_t changes = 0;
  std::uint64_t bounded = 0;  ///< ticks with a work budget
  int pushes = 0;
  int pushed_snapshots = 0;  ///< with a push under way
};

/// A Snapshot in which a tool is being pushed.
bool has_push(const RecordedMessage& message) {
  v1::Snapshot snapshot;
  if (message.kind != RecordKind::kSnapshot ||
      !snapshot.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
    return false;
  }
  return std::any_of(snapshot.blocks().begin(), snapshot.blocks().end(),
                     [](const v1::StateBlock& block) { return block.name() == "push"; });
}

Happened happened_in(const std::string& path) {
  Happened happened;
  RecordingReader reader(path);
  RecordedMessage message;
  while (reader.next(message)) {
    happened.pushed_snapshots += has_push(message) ? 1 : 0;
    if (message.kind != RecordKind::kTick) continue;
    v1::TickRecord tick;
    REQUIRE(tick.ParseFromArray(message.data.data(), static_cast<int>(message.data.size())));
    happened.fault = happened.fault || tick.loop_state() == v1::LOOP_STATE_FAULT;
    happened.second_scene = happened.second_scene || tick.scene_id() == 2;
    happened.skipped = happened.skipped || tick.skipped() > 0;
    if (tick.change() != 0) ++happened.changes;
    if (tick.budget().work() != 0) ++happened.bounded;
    if (tick.inputs(0).push() != v1::AXIS_UNSPECIFIED) ++happened.pushes;
    const auto& force = tick.outputs(0).wrench_h_w().f_n();
    if (force[0] != 0.0 || force[1] != 0.0 || force[2] != 0.0) ++happened.contacts;
  }
  return happened;
}

}  // namespace

TEST_CASE("a recorded session is replayed to the bit under both clocks") {
  for (const bool virtual_time : {true, false}) {
    CAPTURE(virtual_time);
    const std::string path = recorded().path(virtual_time);
    const Happened happened = happened_in(path);
    CHECK(happened.contacts > 500);
    CHECK(happened.fault);
    CHECK(happened.second_scene);
    CHECK(happened.changes == 3);
    CHECK(happened.bounded > 1000);
    CHECK(happened.pushes == 3);
    CHECK(happened.pushed_snapshots >= 1);
    CHECK(happened.skipped == !virtual_time);
    const ReplayReport report = verify(path);
    CHECK(report.first_difference == "");
    CHECK(report.ticks == kSessionTicks);
    CHECK(report.different_ticks == 0);
    CHECK(report.states >= 3);
    CHECK(report.different_states == 0);
    CHECK(report.gaps == 0);
  }
}

TEST_CASE("a replay from any Snapshot on is the same to the bit") {
  const TemporaryFolder folder;
  for (const bool virtual_time : {true, false}) {
    int snapshots = 0;
    const auto part = [&] {
      return folder.file(std::to_string(snapshots) + (virtual_time ? "v.mcap" : "r.mcap"));
    };
    while (copy_from_snapshot(recorded().path(virtual_time), snapshots, part())) {
      CAPTURE(virtual_time);
      CAPTURE(snapshots);
      const ReplayReport report = verify(part());
      ++snapshots;
      CHECK(report.first_difference == "");
      CHECK(report.ticks > 0);
    }
    CHECK(snapshots >= 4);
  }
}

TEST_CASE("the work that a tick was allowed is part of what is replayed") {
  const TemporaryFolder folder;
  copy_changed(recorded().path(true), folder.file("changed.mcap"), [](v1::TickRecord& tick) {
    tick.mutable_budget()->set_work(1);
    return true;
  });
  const ReplayReport report = verify(folder.file("changed.mcap"));
  CHECK(report.different_ticks >= 1);
}

TEST_CASE("one bit of one recorded pose turned over is found in that tick") {
  const TemporaryFolder folder;
  constexpr std::uint64_t kTick = 480;
  copy_changed(recorded().path(true), folder.file("changed.mcap"), [](v1::TickRecord& tick) {
    if (tick.scene_id() != 1 || tick.tick() != kTick) return true;
    double& y = *tick.mutable_inputs(0)->mutable_pose_dh()->mutable_p_m()->Mutable(1);
    y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(y) ^ 1U);
    return true;
  });
  const ReplayReport report = verify(folder.file("changed.mcap"));
  CHECK(report.different_ticks >= 1);
  CHECK(report.first_difference.find("tick 480 of scene 1") == 0);
}

TEST_CASE("an order that is left out of a recording is found") {
  const TemporaryFolder folder;
  copy_changed(recorded().path(true), folder.file("changed.mcap"), [](v1::TickRecord& tick) {
    if (tick.scene_id() == 1 && tick.tick() == 1100) tick.clear_orders();
    return true;
  });
  const ReplayReport report = verify(folder.file("changed.mcap"));
  CHECK(report.first_difference.find("tick 1100 of scene 1") == 0);
}

TEST_CASE("a push that is left out of a recording is found") {
  const TemporaryFolder folder;
  copy_changed(recorded().path(true), folder.file("changed.mcap"), [](v1::TickRecord& tick) {
    tick.mutable_inputs(0)->clear_push();
    return true;
  });
  // The force of its first tick is zero, as it is where nothing is touched.
  CHECK(verify(folder.file("changed.mcap")).first_difference.find("of scene 1") !=
        std::string::npos);
}

TEST_CASE("behind lost ticks a replay goes on at the next Snapshot") {
  const TemporaryFolder folder;
  copy_changed(recorded().path(false), folder.file("lossy.mcap"), [](v1::TickRecord& tick) {
    return tick.scene_id() != 1 || tick.tick() < 300 || tick.tick() >= 310;
  });
  ReplayReport report;
  CHECK_NOTHROW(report = verify(folder.file("lossy.mcap")));
  CHECK(report.gaps == 1);
  CHECK(report.skipped_ticks > 0);
  CHECK(report.ticks > 2000);
  CHECK(report.first_difference == "");
}

TEST_CASE("what a killed daemon left is replayed as far as it goes") {
  const TemporaryFolder folder;
  std::filesystem::copy_file(recorded().path(false), folder.file("killed.mcap"));
  const auto size = std::filesystem::file_size(folder.file("killed.mcap"));
  std::filesystem::resize_file(folder.file("killed.mcap"), size * 2 / 3);
  const ReplayReport report = verify(folder.file("killed.mcap"));
  CHECK(report.ticks > 0);
  CHECK(report.ticks < kSessionTicks);
  CHECK(report.first_difference == "");
}

TEST_CASE("a recording begins at its first Snapshot, and without one is refused") {
  const TemporaryFolder folder;
  copy_changed(recorded().path(true), folder.file("headless.mcap"), [](v1::TickRecord& tick) {
    tick.set_first(false);
    return true;
  });
  const ReplayReport report = verify(folder.file("headless.mcap"));
  CHECK(report.first_difference == "");
  CHECK(report.skipped_ticks == 1);
  // Not even the first chunk is whole.
  std::filesystem::copy_file(recorded().path(true), folder.file("short.mcap"));
  std::filesystem::resize_file(folder.file("short.mcap"), 20'000);
  CHECK_THROWS_AS(verify(folder.file("short.mcap")), RecordingError);
}

}  // namespace hapticd::test
