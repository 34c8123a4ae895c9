// The ring against std::deque in one thread, and its order and completeness between two.
#include "core/rt/spsc_ring.h"

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <thread>

#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace {

using hapticd::SpscRing;
using hapticd::test::scaled;

/// Long enough that a torn copy shows.
struct Item {
  std::array<std::uint64_t, 8> words{};
};

Item make_item(std::uint64_t number) {
  Item item;
  for (std::uint64_t i = 0; i < item.words.size(); ++i) item.words[i] = number * (i + 1);
  return item;
}

bool is_item(const Item& item, std::uint64_t number) {
  return item.words == make_item(number).words;
}

/// A ring beside the queue it must behave as.
template <std::size_t Capacity>
class Comparison {
 public:
  void push() {
    ++last_pushed_;
    const bool fits = model_.size() < Capacity;
    same_ = same_ && ring_.push(make_item(last_pushed_)) == fits;
    if (fits) {
      model_.push_back(last_pushed_);
    } else {
      ++refused_;
    }
    same_ = same_ && ring_.overflow() == refused_;
  }

  void pop() {
    Item item = make_item(0);
    const bool popped = ring_.pop(item);
    same_ =
        same_ && popped == !model_.empty() && is_item(item, model_.empty() ? 0 : model_.front());
    if (!model_.empty()) model_.pop_front();
  }

  [[nodiscard]] bool same() const { return same_; }

 private:
  SpscRing<Item, Capacity> ring_;
  std::deque<std::uint64_t> model_;
  std::uint64_t last_pushed_ = 0;
  std::uint64_t refused_ = 0;
  bool same_ = true;
};

/// Whether a ring of this capacity is a queue over random bursts of pushes and pops.
template <std::size_t Capacity>
bool behaves_as_queue(std::uint64_t seed) {
  hapticd::test::SplitMix64 random(seed);
  Comparison<Capacity> comparison;
  const std::int64_t bursts = scaled(100'000);
  for (std::int64_t i = 0; i < bursts; ++i) {
    const bool push = random.chance(0.5);
    const std::uint64_t length = random.below(2 * Capacity + 1);
    for (std::uint64_t k = 0; k < length; ++k) {
      if (push) {
        comparison.push();
      } else {
        comparison.pop();
      }
    }
  }
  return comparison.same();
}

}  // namespace

TEST_CASE("a ring behaves as a queue with a limit under random operations, at any capacity") {
  CHECK(behaves_as_queue<1>(601));
  CHECK(behaves_as_queue<2>(602));
  CHECK(behaves_as_queue<4>(603));
  CHECK(behaves_as_queue<64>(604));
}

TEST_CASE("every sequence of twelve pushes and pops leaves a ring as it leaves a queue") {
  bool same = true;
  for (unsigned sequence = 0; sequence < 1U << 12U; ++sequence) {
    Comparison<4> comparison;
    for (unsigned step = 0; step < 12; ++step) {
      if ((sequence >> step & 1U) != 0) {
        comparison.push();
      } else {
        comparison.pop();
      }
    }
    same = same && comparison.same();
  }
  CHECK(same);
}

TEST_CASE("between two threads every item arrives once, whole and in order") {
  const auto count = static_cast<std::uint64_t>(scaled(2'000'000));
  SpscRing<Item, 64> ring;
  std::uint64_t tried_in_vain = 0;
  std::thread writer([&] {
    for (std::uint64_t number = 1; number <= count; ++number) {
      while (!ring.push(make_item(number))) {
        ++tried_in_vain;
        std::this_thread::yield();
      }
    }
  });
  bool in_order = true;
  for (std::uint64_t number = 1; number <= count; ++number) {
    Item item;
    while (!ring.pop(item)) std::this_thread::yield();
    in_order = in_order && is_item(item, number);
  }
  writer.join();
  Item rest;
  CHECK(in_order);
  CHECK_FALSE(ring.pop(rest));
  CHECK(ring.overflow() == tried_in_vain);
}

TEST_CASE("between two threads what is not refused arrives, and what is refused is counted") {
  const auto count = static_cast<std::uint64_t>(scaled(2'000'000));
  SpscRing<std::uint64_t, 16> ring;
  std::uint64_t accepted = 0;
  std::thread writer([&] {
    for (std::uint64_t number = 1; number <= count; ++number) {
      if (ring.push(number)) ++accepted;
    }
    while (!ring.push(count + 1)) std::this_thread::yield();
  });
  std::uint64_t arrived = 0;
  std::uint64_t last = 0;
  bool increasing = true;
  while (last != count + 1) {
    std::uint64_t number = 0;
    if (!ring.pop(number)) {
      std::this_thread::yield();
      continue;
    }
    increasing = increasing && number > last;
    last = number;
    ++arrived;
  }
  writer.join();
  CHECK(increasing);
  CHECK(arrived == accepted + 1);
  CHECK(ring.overflow() >= count - accepted);
}

TEST_CASE("neither side of a ring touches the heap") {
  SpscRing<Item, 4> ring;
  Item item;
  const hapticd::test::NoHeapScope scope;
  for (std::uint64_t i = 0; i < 10; ++i) ring.push(item);
  while (ring.pop(item)) {
  }
  const std::int64_t heap_calls = scope.count();
  CHECK(heap_calls == 0);
}

TEST_CASE("items written in place arrive as pushed ones do, and a full ring has no place") {
  SpscRing<Item, 4> ring;
  for (std::uint64_t round = 0; round < 3; ++round) {
    for (std::uint64_t i = 0; i < 4; ++i) {
      Item* const place = ring.writable();
      REQUIRE(place != nullptr);
      *place = make_item(4 * round + i);
      ring.publish();
    }
    CHECK(ring.writable() == nullptr);
    CHECK(ring.overflow() == round + 1);
    for (std::uint64_t i = 0; i < 4; ++i) {
      REQUIRE(ring.front() != nullptr);
      CHECK(is_item(*ring.front(), 4 * round + i));
      ring.release();
    }
    CHECK(ring.front() == nullptr);
  }
}

TEST_CASE("a place that was asked for and not published is not seen, and is given again") {
  SpscRing<Item, 2> ring;
  Item* const place = ring.writable();
  *place = make_item(1);
  CHECK(ring.front() == nullptr);
  CHECK(ring.writable() == place);
}
