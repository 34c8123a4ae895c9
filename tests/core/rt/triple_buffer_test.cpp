// The triple buffer against "the newest one written" in one thread, and against tearing and going
// back between two.
#include "core/rt/triple_buffer.h"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <thread>

#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace {

using hapticd::TripleBuffer;
using hapticd::test::scaled;

/// Eight cache lines, all equal when whole.
struct Snapshot {
  std::array<std::uint64_t, 64> words{};
};

void fill(Snapshot& snapshot, std::uint64_t number) { snapshot.words.fill(number); }

bool is_whole(const Snapshot& snapshot) {
  for (const std::uint64_t word : snapshot.words) {
    if (word != snapshot.words[0]) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("before the first snapshot the reader sees an empty one and nothing new") {
  TripleBuffer<Snapshot> buffer;
  CHECK_FALSE(buffer.update());
  CHECK(buffer.latest().words[0] == 0);
}

TEST_CASE("the reader gets the newest snapshot once and keeps it until the next") {
  hapticd::test::SplitMix64 random(701);
  TripleBuffer<std::uint64_t> buffer;
  std::uint64_t written = 0;
  std::uint64_t seen = 0;
  bool right = true;
  const std::int64_t count = scaled(200'000);
  for (std::int64_t i = 0; i < count; ++i) {
    switch (random.below(3)) {
      case 0:
        buffer.write(++written);
        break;
      case 1:
        // A slot being filled is invisible until it is published.
        buffer.writable() = ~std::uint64_t{0};
        break;
      default:
        right = right && buffer.update() == (written != seen);
        seen = written;
    }
    right = right && buffer.latest() == seen;
  }
  CHECK(right);
}

TEST_CASE(
    "between two threads a snapshot is never torn, never goes back, and the last one arrives") {
  const auto count = static_cast<std::uint64_t>(scaled(2'000'000));
  TripleBuffer<Snapshot> buffer;
  std::thread writer([&] {
    for (std::uint64_t number = 1; number <= count; ++number) {
      fill(buffer.writable(), number);
      buffer.publish();
    }
  });
  bool whole = true;
  bool forward = true;
  std::uint64_t last = 0;
  while (last != count) {
    if (!buffer.update()) {
      std::this_thread::yield();
      continue;
    }
    const Snapshot& snapshot = buffer.latest();
    whole = whole && is_whole(snapshot);
    forward = forward && snapshot.words[0] > last;
    last = snapshot.words[0];
  }
  writer.join();
  CHECK(whole);
  CHECK(forward);
  CHECK_FALSE(buffer.update());
}

TEST_CASE("neither side of a triple buffer touches the heap") {
  TripleBuffer<Snapshot> buffer;
  const Snapshot snapshot;
  const hapticd::test::NoHeapScope scope;
  buffer.write(snapshot);
  buffer.update();
  const std::int64_t heap_calls = scope.count();
  CHECK(heap_calls == 0);
}
