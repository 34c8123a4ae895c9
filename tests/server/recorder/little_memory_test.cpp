// Truth: what was handed in is found, by a reader, in the files that a recorder says are whole,
// whichever of its allocations failed.
#include <doctest/doctest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <new>

#include "proto/recording/mapped_file.h"
#include "proto/recording/mcap_reader.h"
#include "proto/wire/prepared_messages.h"
#include "server/recorder/recorder.h"
#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/scale.h"

namespace {

/// Allocations of this thread until those that fail begin, and how many of them do.
thread_local std::int64_t before_failures = -1;
thread_local std::int64_t failures = 0;

void* memory(std::size_t bytes) {
  if (before_failures == 0 && failures > 0) {
    --failures;
    throw std::bad_alloc();
  }
  if (before_failures > 0) --before_failures;
  void* const block = std::malloc(bytes);
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

}  // namespace

void* operator new(std::size_t bytes) { return memory(bytes); }
void* operator new[](std::size_t bytes) { return memory(bytes); }
void operator delete(void* block) noexcept { std::free(block); }
void operator delete[](void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t /*bytes*/) noexcept { std::free(block); }
void operator delete[](void* block, std::size_t /*bytes*/) noexcept { std::free(block); }

namespace hapticd::test {
namespace {

constexpr std::uint64_t kTicks = 12;

/// What a recorder is asked, in this order.
enum class Phase : std::uint8_t { kStart, kTicking, kDump, kStop };
constexpr std::uint64_t kPhases = 4;

/// From the beginning of a phase on, `count` allocations fail after the first `first`.
struct Shortage {
  Phase phase;
  std::int64_t first;
  std::int64_t count;

  void begin(Phase now) const {
    if (now != phase) return;
    failures = count;
    before_failures = first;
  }
  static void end() { before_failures = -1; }
};

/// False where there was no memory for it.
template <typename Work>
bool tried(const Work& work) {
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

struct Counts {
  std::uint64_t ticks = 0;
  std::uint64_t scenes = 0;
  std::uint64_t headers = 0;
  McapEnd end = McapEnd::kMore;
};

Counts counts_of(const std::string& path) {
  MappedFile file;
  std::string error;
  REQUIRE(file.open(path, error));
  McapReader reader(file.bytes());
  Counts counts;
  McapMessage message;
  while (reader.next(message)) {
    const std::string& topic = reader.channels().at(message.channel - 1U).topic;
    counts.ticks += topic == kTickTopic ? 1U : 0U;
    counts.scenes += topic == kRecordTopics[static_cast<std::size_t>(RecordKind::kScene)] ? 1U : 0U;
    counts.headers +=
        topic == kRecordTopics[static_cast<std::size_t>(RecordKind::kHeader)] ? 1U : 0U;
  }
  counts.end = reader.end();
  return counts;
}

/// What a recorder was asked in its life, and what it said.
struct Life {
  TemporaryFolder folder;
  std::string take = folder.file("new/take.mcap");
  std::string dump = folder.file("dump.mcap");
  std::unique_ptr<Tick> tick = std::make_unique<Tick>();
  std::uint64_t ticks = 0;  ///< that it took
  bool started = false;
  bool dumped = false;
};

/// As the recorder's thread calls it. Nothing but the recorder asks for memory.
void live(Recorder& recorder, const Shortage& shortage, Life& life) {
  SplitMix64 random(1);
  shortage.begin(Phase::kStart);
  life.started = tried([&] { life.started = recorder.start(life.take); }) && life.started;
  shortage.begin(Phase::kTicking);
  for (std::uint64_t k = 0; k < kTicks; ++k) {
    *life.tick = any_tick(random, k, 1);
    if (tried([&] { recorder.tick(*life.tick, nullptr); })) {
      ++life.ticks;
    } else {
      recorder.lost_ticks(1);
    }
    if (k % 4 == 0) {
      tried([&] { recorder.add(RecordKind::kSnapshot, k * 1'000'000, sample_snapshot(k + 1)); });
    }
    tried([&] { recorder.poll(k * 100'000'000); });
  }
  std::string error;
  shortage.begin(Phase::kDump);
  life.dumped = tried([&] { life.dumped = recorder.dump(life.dump, error); }) && life.dumped;
  shortage.begin(Phase::kStop);
  recorder.stop();
  Shortage::end();
}

void check_life(const Shortage& shortage) {
  Recorder recorder;
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  Life life;
  live(recorder, shortage, life);
  const RecordStatus status = recorder.status();
  CHECK_FALSE(status.recording);
  if (life.started) {
    const Counts take = counts_of(life.take);
    CHECK(take.headers == 1);
    CHECK(take.scenes == 1);
    CHECK(take.ticks >= status.ticks);
    CHECK(status.ticks + status.lost_ticks == kTicks);
    if (status.error.empty()) {
      CHECK(take.ticks == status.ticks);
      CHECK(take.end == McapEnd::kComplete);
    }
  } else {
    CHECK_FALSE(std::filesystem::exists(life.take));
  }
  if (life.dumped) {
    const Counts dump = counts_of(life.dump);
    CHECK(dump.end == McapEnd::kComplete);
    CHECK(dump.scenes == 1);
    CHECK(dump.ticks == life.ticks);
  }
  // With memory again all of it goes on.
  const std::string again = life.folder.file("again.mcap");
  REQUIRE(recorder.start(again));
  recorder.tick(*life.tick, nullptr);
  recorder.stop();
  CHECK(counts_of(again).ticks == 1);
}

TEST_CASE("a recorder outlives allocations that fail, and says what its files lack") {
  wire::prepare_messages();  // as the daemon does before it begins
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (std::int64_t run = 0; run < scaled(2000); ++run) {
    const auto phase = static_cast<Phase>(random.below(kPhases));
    // Of what an allocation in this life is: one of few, or of the thousands that begin a file.
    const auto first = static_cast<std::int64_t>(random.below(random.chance(0.7) ? 40 : 20'000));
    constexpr std::int64_t kCounts[] = {1, 3, 20, 1'000'000};
    const Shortage shortage{phase, first, kCounts[random.below(4)]};
    CAPTURE(static_cast<int>(phase));
    CAPTURE(first);
    CAPTURE(shortage.count);
    check_life(shortage);
  }
}

}  // namespace
}  // namespace hapticd::test
