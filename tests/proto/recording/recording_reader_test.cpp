// Truth: what was recorded.
#include "proto/recording/recording_reader.h"

#include <doctest/doctest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "server/recorder/recorder.h"
#include "server/recorder/tick_difference.h"
#include "server/recorder/tick_record.h"
#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A session of `ticks` ticks; without a summary when `killed`.
void write_session(const std::string& path, int ticks, bool killed) {
  SplitMix64 random(7);
  Recorder recorder;
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  REQUIRE(recorder.start(path));
  for (int k = 0; k < ticks; ++k) {
    recorder.tick(any_tick(random, static_cast<std::uint64_t>(k), 1), nullptr);
  }
  if (killed) {
    recorder.poll(1'000'000'000);
    std::filesystem::copy_file(path, path + ".killed");
  }
  recorder.stop();
}

}  // namespace

TEST_CASE("a recording is read message by message, and summed up") {
  const TemporaryFolder folder;
  write_session(folder.file("a.mcap"), 50, false);
  RecordingReader reader(folder.file("a.mcap"));
  CHECK(reader.header().server_version() == "test");
  const RecordingSummary summary = summarise(reader);
  CHECK(summary.ticks == 50);
  CHECK(summary.last_tick == 49);
  CHECK(summary.complete);
  RecordedMessage message;
  REQUIRE(reader.next(message));
  CHECK(message.kind == RecordKind::kScene);
  int ticks = 0;
  while (reader.next(message)) ticks += message.kind == RecordKind::kTick ? 1 : 0;
  CHECK(ticks == 50);
}

TEST_CASE("a recording is read by the name that the list shows, from any folder") {
  const TemporaryFolder folder;
  const std::filesystem::path listed = std::filesystem::path(folder.file("hapticd")) / "recordings";
  std::filesystem::create_directories(listed);
  write_session((listed / "only there.mcap").string(), 5, false);
  // NOLINTNEXTLINE(concurrency-mt-unsafe): one thread
  REQUIRE(setenv("XDG_STATE_HOME", folder.file("").c_str(), 1) == 0);
  RecordingReader reader("only there.mcap");
  CHECK(summarise(reader).ticks == 5);
  RecordingReader shorter("only there");
  CHECK(summarise(shorter).ticks == 5);
  CHECK_THROWS_AS(RecordingReader("./only there.mcap"), RecordingError);
  CHECK_THROWS_WITH_AS(RecordingReader("nowhere.mcap"), doctest::Contains(listed.string().c_str()),
                       RecordingError);
  CHECK_THROWS_WITH(RecordingReader(listed.string()), doctest::Contains(" is a folder. "));
}

TEST_CASE("what a killed daemon left is read as far as it goes") {
  const TemporaryFolder folder;
  write_session(folder.file("a.mcap"), 50, true);
  RecordingReader reader(folder.file("a.mcap.killed"));
  const RecordingSummary summary = summarise(reader);
  CHECK(summary.ticks == 50);
  CHECK(!summary.complete);
  CHECK(!summary.end.empty());
}

TEST_CASE("what is no recording, or of another format, is refused by name with the remedy") {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& name) {
    try {
      const RecordingReader reader(folder.file(name));
    } catch (const RecordingError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal("missing.mcap").find("missing.mcap") != std::string::npos);
  std::ofstream(folder.file("text.mcap")) << "no recording at all";
  CHECK(refusal("text.mcap").find("not a recording of hapticd") != std::string::npos);
  v1::RecordHeader header = sample_header();
  header.set_format_version(kRecordFormat + 1);
  McapWriter writer;
  REQUIRE(writer.open(folder.file("later.mcap"), "test"));
  writer.add_channel(kHeaderTopic, "hapticd.v1.RecordHeader", "");
  writer.write(1, 0, header.SerializeAsString());
  REQUIRE(writer.close());
  CHECK(refusal("later.mcap").find("Use the version that recorded it") != std::string::npos);
}

TEST_CASE("a tick differs from itself in nothing, and from one with any bit flipped by its name") {
  SplitMix64 random(11);
  const auto runs = scaled(3000);
  for (std::int64_t k = 0; k < runs; ++k) {
    const Tick tick = any_tick(random, 5, 2);
    CHECK(tick_difference(tick, tick).empty());
    Tick flipped = tick;
    Array3& force = flipped.tools[1].F_written_H_W.f;
    double& number = force[random.below(3)];
    number =
        std::bit_cast<double>(std::bit_cast<std::uint64_t>(number) ^ (1ULL << random.below(64)));
    CHECK(tick_difference(tick, flipped) ==
          "wrench_h_w of tool " + std::to_string(tick.tools[1].tool_id));
    CHECK(tick_difference(tick, flipped, Compared::kPoses).empty());
    flipped.tools[0].X_WH.q[2] = tick.tools[0].X_WH.q[2] == 0.25 ? 0.5 : 0.25;
    CHECK(tick_difference(tick, flipped, Compared::kPoses) ==
          "pose_wh of tool " + std::to_string(tick.tools[0].tool_id));
  }
}

}  // namespace hapticd::test
