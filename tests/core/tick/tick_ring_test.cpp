// Ticks through the ring. Truth: the tick that went in, byte by byte of what is used.
#include "core/tick/tick_ring.h"

#include <doctest/doctest.h>

#include <cstring>
#include <memory>

#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kBytes = 1U << 20U;

template <typename Column>
void fill(Column& column, std::size_t size, SplitMix64& random) {
  column.clear();
  for (std::size_t k = 0; k < size; ++k) {
    auto* place = column.append();
    *place = {};
    // Any bits: NaN and padding among them.
    auto* bytes = reinterpret_cast<unsigned char*>(place);
    for (std::size_t i = 0; i < sizeof(*place); ++i) {
      bytes[i] = static_cast<unsigned char>(random.next());
    }
  }
}

template <typename Column>
bool same(const Column& a, const Column& b) {
  return a.size() == b.size() &&
         std::memcmp(a.begin(), b.begin(), a.size() * sizeof(*a.begin())) == 0;
}

void fill(Tick& tick, std::uint64_t number, double share, SplitMix64& random) {
  tick.tick = number;
  tick.string_energy = static_cast<double>(random.next());
  const auto upto = [&](std::size_t most) {
    return random.below(static_cast<std::uint64_t>(share * static_cast<double>(most)) + 1);
  };
  fill(tick.tools, upto(tick.tools.capacity()), random);
  fill(tick.contacts, upto(tick.contacts.capacity()), random);
  fill(tick.strings, upto(tick.strings.capacity()), random);
  fill(tick.string_forces, upto(tick.string_forces.capacity()), random);
  fill(tick.string_bends, upto(tick.string_bends.capacity()), random);
}

bool same(const Tick& a, const Tick& b) {
  return a.tick == b.tick && a.string_energy == b.string_energy && same(a.tools, b.tools) &&
         same(a.contacts, b.contacts) && same(a.strings, b.strings) &&
         same(a.string_forces, b.string_forces) && same(a.string_bends, b.string_bends);
}

}  // namespace

TEST_CASE("a tick comes out as it went in, the fullest one and those with nothing in them") {
  SplitMix64 random(7);
  const auto ring = std::make_unique<TickRing<kBytes>>();
  const auto sent = std::make_unique<Tick>();
  const auto got = std::make_unique<Tick>();
  for (std::int64_t k = 0; k < scaled(500); ++k) {
    const double share = random.chance(0.2) ? 1.0 : random.chance(0.2) ? 0.0 : 0.02;
    fill(*sent, static_cast<std::uint64_t>(k), share, random);
    REQUIRE(ring->push(*sent));
    REQUIRE(ring->pop(*got));
    REQUIRE(same(*sent, *got));
  }
  CHECK_FALSE(ring->pop(*got));
  fill(*sent, 1, 0.0, random);
  for (std::size_t k = 0; k < sent->strings.capacity(); ++k) sent->strings.push_back({});
  for (std::size_t k = 0; k < sent->contacts.capacity(); ++k) sent->contacts.push_back({});
  REQUIRE(ring->push(*sent));
  REQUIRE(ring->pop(*got));
  CHECK(same(*sent, *got));
}

TEST_CASE("a full ring refuses and counts, and keeps what it has") {
  SplitMix64 random(8);
  const auto ring = std::make_unique<TickRing<kBytes>>();
  const auto tick = std::make_unique<Tick>();
  fill(*tick, 0, 0.0, random);
  std::uint64_t taken = 0;
  for (; ring->push(*tick); tick->tick = ++taken) {
  }
  CHECK(ring->overflow() == 1);
  // A tick that is usual takes what it uses, no more.
  CHECK(taken > 1000);
  for (std::uint64_t k = 0; k < taken; ++k) {
    REQUIRE(ring->pop(*tick));
    REQUIRE(tick->tick == k);
  }
  CHECK_FALSE(ring->pop(*tick));
}

TEST_CASE("a tick passes without the heap") {
  SplitMix64 random(9);
  const auto ring = std::make_unique<TickRing<kBytes>>();
  const auto tick = std::make_unique<Tick>();
  fill(*tick, 0, 0.1, random);
  const NoHeapScope scope;
  for (int k = 0; k < 100; ++k) {
    static_cast<void>(ring->push(*tick));
    static_cast<void>(ring->pop(*tick));
  }
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
}

}  // namespace hapticd::test
