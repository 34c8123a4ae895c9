// Truth: what was handed in, found again by readers that are not ours: @mcap/core and a reader from
// the specification in Python; a process killed in the middle; a disk that is full.
#include "server/recorder/recorder.h"

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "proto/recording/mapped_file.h"
#include "proto/recording/mcap_bytes.h"
#include "proto/recording/mcap_reader.h"
#include "server/recorder/tick_record.h"
#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/scale.h"
#include "tests/support/shell_run.h"

namespace hapticd::test {
namespace {

/// Output of a command; its failure fails the test.
std::string run(const std::string& command) {
  const ShellOutcome outcome = run_in_shell(command + " 2>&1");
  if (outcome.code != 0) FAIL(command << " failed: " << outcome.text);
  return outcome.text;
}

/// Rows as the foreign readers print them, from our own reader, and the ticks' numbers.
struct Contents {
  std::string rows;
  std::vector<std::uint64_t> ticks;
  std::vector<std::uint64_t> snapshots;  ///< their next_tick
  std::string scene;                     ///< name of the first
  std::uint64_t bytes = 0;               ///< of all messages
  std::string first_topics;              ///< of the first three messages
  McapEnd end = McapEnd::kMore;
};

Contents contents_of(const std::string& path) {
  MappedFile file;
  std::string error;
  REQUIRE(file.open(path, error));
  McapReader reader(file.bytes());
  Contents contents;
  struct Row {
    std::uint64_t count = 0;
    std::uint64_t bytes = 0;
    std::uint32_t crc = 0;
  };
  std::map<std::string, Row> rows;
  std::map<std::string, std::string> types;
  const auto tick = std::make_unique<Tick>();
  McapMessage message;
  int read = 0;
  while (reader.next(message)) {
    const McapChannel& channel = reader.channels().at(message.channel - 1U);
    Row& row = rows[channel.topic];
    types[channel.topic] = reader.schemas().at(channel.schema_id - 1U).name;
    ++row.count;
    row.bytes += message.data.size();
    contents.bytes += message.data.size();
    row.crc = mcap_crc(message.data, row.crc);
    if (read++ < 3) contents.first_topics += channel.topic + " ";
    const std::string data(message.data);
    if (channel.topic == kTickTopic) {
      v1::TickRecord record;
      REQUIRE(record.ParseFromString(data));
      REQUIRE(to_tick(record, *tick));
      contents.ticks.push_back(tick->tick);
    }
    if (channel.topic == kSnapshotTopic) {
      v1::Snapshot snapshot;
      REQUIRE(snapshot.ParseFromString(data));
      contents.snapshots.push_back(snapshot.next_tick());
    }
    if (channel.topic == kSceneTopic && contents.scene.empty()) {
      v1::SceneRecord scene;
      REQUIRE(scene.ParseFromString(data));
      contents.scene = scene.scene().name();
    }
  }
  for (const auto& [topic, row] : rows) {
    contents.rows += topic + " " + types[topic] + " " + std::to_string(row.count) + " " +
                     std::to_string(row.bytes) + " " + std::to_string(row.crc) + "\n";
  }
  contents.end = reader.end();
  return contents;
}

/// `count` ticks from `first` on, a snapshot before every `per_snapshot`-th, polled by their time.
void feed(Recorder& recorder, std::uint64_t first, std::uint64_t count,
          std::uint64_t per_snapshot = 1000, int tools = 1) {
  SplitMix64 random(first + 1);
  for (std::uint64_t tick = first; tick < first + count; ++tick) {
    if (tick % per_snapshot == 0)
      recorder.add(RecordKind::kSnapshot, tick * 1'000'000, sample_snapshot(tick));
    recorder.tick(any_tick(random, tick, tools), nullptr);
    recorder.poll(tick * 1'000'000);
  }
}

/// A session of 3 s with everything in it.
std::string whole_session(const TemporaryFolder& folder, const std::string& name) {
  Recorder recorder;
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  REQUIRE(recorder.start(folder.file(name)));
  feed(recorder, 0, 2000);
  v1::ParameterRecord parameters;
  parameters.set_tick(2000);
  parameters.add_assignments()->set_path("strings[3].tension_n");
  recorder.add(RecordKind::kParameters, 2'000'000'000, parameters);
  v1::EventRecord event;
  event.set_tick(2001);
  event.mutable_item()->mutable_tone()->set_string_index(3);
  recorder.add(RecordKind::kEvent, 2'001'000'000, event);
  feed(recorder, 2000, 1000);
  recorder.stop();
  CHECK(recorder.status().error.empty());
  CHECK(recorder.status().ticks == 3000);
  CHECK_FALSE(recorder.status().recording);
  return folder.file(name);
}

/// What @mcap/core finds in the file; `mode`: indexed or stream.
std::string read_core(const std::string& mode, const std::string& path) {
  std::string command = HAPTICD_NODE " " HAPTICD_MCAP_CORE "/read_with_core.mjs ";
  command.append(mode).append(" ").append(path);
  return run(command);
}

/// What the reader from the specification finds.
std::string read_python(const std::string& path) {
  std::string command = "/usr/bin/python3 -B " HAPTICD_RECORDER_TESTS "/read_recording.py ";
  command.append(path);
  return run(command);
}

}  // namespace

TEST_CASE("@mcap/core and a reader from the specification find in a session what we put there") {
  const TemporaryFolder folder;
  const std::string path = whole_session(folder, "session.mcap");
  const Contents ours = contents_of(path);
  CHECK(ours.end == McapEnd::kComplete);
  CHECK(ours.ticks.size() == 3000);
  CHECK(ours.rows.find("/hapticd/event hapticd.v1.EventRecord 1 ") != std::string::npos);
  CHECK(read_core("indexed", path) == ours.rows);
  CHECK(read_core("stream", path) == ours.rows);
  const std::string python = read_python(path);
  CHECK(python.substr(0, ours.rows.size()) == ours.rows);
  CHECK(python.find("ticks 0 2999\n") != std::string::npos);
  // The bits of the last wrench, by Python's protobuf and the schema in the file.
  SplitMix64 random(2001);
  Tick last;
  for (std::uint64_t tick = 2000; tick < 3000; ++tick) last = any_tick(random, tick, 1);
  std::string wrench = "wrench";
  for (const double x : last.tools[0].F_written_H_W.f) {
    std::array<char, 18> hex{};
    std::snprintf(hex.data(), hex.size(), " %016llx",
                  static_cast<unsigned long long>(std::bit_cast<std::uint64_t>(x)));
    wrench += hex.data();
  }
  CHECK(python.find(wrench) != std::string::npos);
}

TEST_CASE("a killed process loses at most 100 ms, and what it left opens in @mcap/core") {
  const TemporaryFolder folder;
  SplitMix64 random(97);
  for (std::int64_t round = 0; round < scaled(30); ++round) {
    const std::string path = folder.file("killed" + std::to_string(round) + ".mcap");
    std::array<int, 2> pipe{};
    REQUIRE(::pipe(pipe.data()) == 0);
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      // One tick after the other for ever; each is told before it is recorded.
      Recorder recorder;
      recorder.begin(sample_header());
      recorder.add(RecordKind::kScene, 0, sample_scene(1));
      bool good = recorder.start(path);
      for (std::uint64_t tick = 0; good; ++tick) {
        feed(recorder, tick, 1);
        good = ::write(pipe[1], &tick, sizeof(tick)) == sizeof(tick);
      }
      ::_exit(1);
    }
    ::close(pipe[1]);
    const std::uint64_t enough = 200 + random.below(3000);
    std::uint64_t told = 0;
    while (told < enough && ::read(pipe[0], &told, sizeof(told)) == sizeof(told)) {
    }
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    REQUIRE(WIFSIGNALED(status));
    while (::read(pipe[0], &told, sizeof(told)) == sizeof(told)) {
    }
    ::close(pipe[0]);

    const Contents left = contents_of(path);
    REQUIRE(left.end == McapEnd::kTruncated);
    REQUIRE(left.ticks.size() + 100 >= told + 1);
    for (std::size_t k = 0; k < left.ticks.size(); ++k) REQUIRE(left.ticks[k] == k);
    if (round > 0) continue;
    CHECK(read_core("stream", path) == left.rows);
  }
}

TEST_CASE(
    "a full disk is said, costs no tick that was written, and leaves a file that can be read") {
  const TemporaryFolder folder;
  const std::string path = folder.file("full.mcap");
  Recorder recorder;
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  REQUIRE(recorder.start(path));
  feed(recorder, 0, 500);
  // No file may grow beyond this, as if the disk were full.
  struct rlimit before {};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  struct rlimit limit = before;
  limit.rlim_cur = recorder.status().bytes + 100'000;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &limit) == 0);
  feed(recorder, 500, 1500);
  const RecordStatus full = recorder.status();
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  (void)std::signal(SIGXFSZ, handler);
  CHECK_FALSE(full.recording);
  CHECK(full.error.find("full.mcap: cannot write: File too large") != std::string::npos);
  CHECK(full.ticks + full.lost_ticks == 2000);
  CHECK(full.ticks >= 500);
  recorder.stop();
  CHECK(recorder.status().error == full.error);
  CHECK(std::filesystem::file_size(path) == full.bytes);  // nothing half written is left
  const Contents left = contents_of(path);
  CHECK(left.ticks.size() == full.ticks);
  CHECK(read_core("stream", path) == left.rows);
  // The flight recorder has all of it, and another session may begin.
  std::string error;
  REQUIRE(recorder.dump(folder.file("dump.mcap"), error));
  CHECK(contents_of(folder.file("dump.mcap")).ticks.size() == 2000);
  CHECK(recorder.start(folder.file("next.mcap")));
}

TEST_CASE(
    "the ring keeps the last minute and begins with a snapshot; a dump has header and scene") {
  const TemporaryFolder folder;
  RecorderOptions options;
  options.flight_ns = 6'000'000'000;  // a minute in little
  Recorder recorder(options);
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  feed(recorder, 0, 12'345, 1000, 0);
  std::string error;
  REQUIRE(recorder.dump(folder.file("dump.mcap"), error));
  const Contents dumped = contents_of(folder.file("dump.mcap"));
  CHECK(dumped.end == McapEnd::kComplete);
  CHECK(dumped.first_topics == "/hapticd/header /hapticd/scene /hapticd/snapshot ");
  CHECK(dumped.scene == "scene_1");
  CHECK(dumped.snapshots.front() == dumped.ticks.front());
  CHECK(dumped.ticks.front() == 6000);
  CHECK(dumped.ticks.back() == 12'344);
  CHECK(dumped.ticks.size() == 6345);
}

TEST_CASE(
    "before its time is full a dump holds everything, and a scene loaded meanwhile in its place") {
  const TemporaryFolder folder;
  Recorder recorder;
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  feed(recorder, 0, 100);
  recorder.add(RecordKind::kScene, 100'000'000, sample_scene(2));
  feed(recorder, 100, 100);
  std::string error;
  REQUIRE(recorder.dump(folder.file("dump.mcap"), error));
  const Contents dumped = contents_of(folder.file("dump.mcap"));
  CHECK(dumped.ticks.size() == 200);
  CHECK(dumped.scene == "scene_1");
  CHECK(dumped.rows.find("/hapticd/scene hapticd.v1.SceneRecord 2 ") != std::string::npos);
}

TEST_CASE("memory is bounded, with snapshots and without") {
  const TemporaryFolder folder;
  std::string error;
  RecorderOptions options;
  options.flight_bytes = 200'000;
  for (const std::uint64_t per_snapshot : {50U, 1'000'000'000U}) {
    Recorder recorder(options);
    recorder.begin(sample_header());
    feed(recorder, 1, 3000, per_snapshot);
    const std::string dump = folder.file(std::to_string(per_snapshot) + ".mcap");
    REQUIRE(recorder.dump(dump, error));
    const std::uint64_t bytes = contents_of(dump).bytes;
    CHECK(bytes <= options.flight_bytes);
    CHECK(bytes > options.flight_bytes / 2);
  }
  options.flight_bytes = 1U << 30U;
  options.flight_ns = 1'000'000'000;
  Recorder no_snapshots(options);
  no_snapshots.begin(sample_header());
  feed(no_snapshots, 1, 8000, 1'000'000'000, 0);
  REQUIRE(no_snapshots.dump(folder.file("no_snapshots.mcap"), error));
  CHECK(contents_of(folder.file("no_snapshots.mcap")).ticks.size() <= 6001);
}

TEST_CASE("the ring ages where virtual time begins again with every scene") {
  const TemporaryFolder folder;
  RecorderOptions options;
  options.flight_ns = 2'000'000'000;
  Recorder recorder(options);
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  feed(recorder, 0, 5000, 1000, 0);
  for (std::uint32_t scene = 2; scene < 20; ++scene) {
    recorder.add(RecordKind::kScene, 0, sample_scene(scene));
    feed(recorder, 0, 1000, 1000, 0);
  }
  std::string error;
  REQUIRE(recorder.dump(folder.file("dump.mcap"), error));
  const std::size_t ticks = contents_of(folder.file("dump.mcap")).ticks.size();
  CHECK(ticks >= 2000);
  CHECK(ticks <= 3001);
}

TEST_CASE("what cannot be begun is refused with the reason") {
  const TemporaryFolder folder;
  Recorder recorder;
  feed(recorder, 0, 10);
  std::string error;
  CHECK_FALSE(recorder.start(folder.file("early.mcap")));
  CHECK(recorder.status().error.find("nothing to record yet") != std::string::npos);
  CHECK_FALSE(recorder.dump(folder.file("early.mcap"), error));
  recorder.begin(sample_header());
  feed(recorder, 0, 10);
  std::ofstream(folder.file("file")) << "mine";
  for (const char* name : {"file/take.mcap", "file/deeper/take.mcap"}) {
    CHECK_FALSE(recorder.start(folder.file(name)));
    CHECK(recorder.status().error.find("Not a directory") != std::string::npos);
    CHECK_FALSE(recorder.dump(folder.file(name), error));
    CHECK(error.find("Not a directory") != std::string::npos);
  }
  CHECK_FALSE(recorder.start(folder.file("file")));
  CHECK(recorder.status().error.find("File exists") != std::string::npos);
  CHECK(std::filesystem::file_size(folder.file("file")) == 4);
  CHECK_FALSE(recorder.start(folder.file("missing/folder/")));
  CHECK_FALSE(std::filesystem::exists(folder.file("missing")));
  REQUIRE(recorder.start(folder.file("a.mcap")));
  CHECK_FALSE(recorder.start(folder.file("b.mcap")));
  recorder.lost_ticks(7);
  CHECK(recorder.status().lost_ticks == 7);
}

}  // namespace hapticd::test
