// The ring of records against std::deque in one thread, and its order and completeness between two.
#include "core/rt/record_ring.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <thread>

#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kBytes = 4096;
using Ring = RecordRing<kBytes>;

/// Length of record number `number`.
std::size_t length_of(std::uint64_t number) {
  SplitMix64 random(number);
  return 1 + random.below(Ring::kMaxRecord);
}

std::byte content_of(std::uint64_t number, std::size_t place) {
  return static_cast<std::byte>((number * 31 + place * 7) & 0xffU);
}

bool write(Ring& ring, std::uint64_t number) {
  const std::span<std::byte> place = ring.writable(length_of(number));
  if (place.empty()) return false;
  for (std::size_t k = 0; k < place.size(); ++k) place[k] = content_of(number, k);
  ring.publish();
  return true;
}

bool is_record(std::span<const std::byte> record, std::uint64_t number) {
  if (record.size() != length_of(number)) return false;
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (record[k] != content_of(number, k)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("records come out whole and in order, none is lost unseen, and space comes back") {
  const auto ring = std::make_unique<Ring>();
  std::deque<std::uint64_t> model;
  SplitMix64 random(3);
  std::uint64_t number = 0;
  std::uint64_t refused = 0;
  std::uint64_t passed = 0;
  for (std::int64_t i = 0; i < scaled(300'000); ++i) {
    if (random.chance(0.52)) {
      ++number;
      write(*ring, number) ? model.push_back(number) : static_cast<void>(++refused);
      REQUIRE(ring->overflow() == refused);
      continue;
    }
    const std::span<const std::byte> oldest = ring->front();
    REQUIRE(oldest.empty() == model.empty());
    if (model.empty()) continue;
    REQUIRE(is_record(oldest, model.front()));
    model.pop_front();
    ring->release();
    ++passed;
  }
  CHECK(refused > 0);
  CHECK(passed > 1000);
  while (!ring->front().empty()) ring->release();
  CHECK(ring->size() == 0);
  // Empty, it takes the longest record wherever it stands.
  for (int k = 0; k < 100; ++k) {
    REQUIRE_FALSE(ring->writable(Ring::kMaxRecord).empty());
    ring->publish();
    ring->release();
  }
  CHECK(ring->writable(Ring::kMaxRecord + 1).empty());
}

TEST_CASE("what is written but not published is not read") {
  const auto ring = std::make_unique<Ring>();
  REQUIRE_FALSE(ring->writable(100).empty());
  CHECK(ring->front().empty());
  REQUIRE(write(*ring, 5));
  CHECK(is_record(ring->front(), 5));
}

TEST_CASE("between two threads every record that was taken in comes out once, in order") {
  const auto ring = std::make_unique<Ring>();
  const auto count = static_cast<std::uint64_t>(scaled(200'000));
  bool right = true;
  std::thread reader([&] {
    for (std::uint64_t number = 1; number <= count;) {
      // It looks all the time, so that it also looks while a record begins at the ring's start.
      const std::span<const std::byte> oldest = ring->front();
      if (oldest.empty()) continue;
      right = is_record(oldest, number++) && right;
      ring->release();
    }
  });
  for (std::uint64_t number = 1; number <= count;) {
    if (write(*ring, number)) {
      ++number;
    } else {
      std::this_thread::yield();
    }
  }
  reader.join();
  CHECK(right);
}

TEST_CASE("a record passes without the heap") {
  const auto ring = std::make_unique<Ring>();
  const NoHeapScope scope;
  for (std::uint64_t number = 1; number < 1000; ++number) {
    static_cast<void>(write(*ring, number));
    if (!ring->front().empty()) ring->release();
  }
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
}

}  // namespace hapticd::test
