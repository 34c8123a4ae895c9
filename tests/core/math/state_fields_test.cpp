// State written down and read back. Truth: the state itself, bit by bit.
#include "core/math/state_fields.h"

#include <doctest/doctest.h>

#include <bit>
#include <cstring>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {

enum class Colour : std::uint8_t { kRed, kBlue };

struct Inner {
  std::uint64_t bits = 0;
  bool on = false;
  std::array<double, 2> pair{};
};

struct Outer {
  Colour colour = Colour::kRed;
  Inner inner;
  Pose pose;
  Wrench wrench;
  FixedVector<std::int32_t, 4> few;
  int count = 0;
  std::array<double, 3> some{};
};

HD_VISIT_FIELDS(Inner, bits, on, pair)

template <FieldsOf<Outer> State, typename Visit>
void visit_fields(State& state, Visit& visit) noexcept {
  auto& [colour, inner, pose, wrench, few, count, some] = state;
  visit.bounded(colour, 0, 1);
  visit(inner, pose, wrench, few);
  visit.bounded(count, 0, 3);
  visit.first(some, count);
}

namespace {

/// Memory for numbers, and what was written into it.
struct Paper {
  std::array<double, 64> reals{};
  std::array<std::int64_t, 64> integers{};
  std::size_t real_count = 0;
  std::size_t integer_count = 0;

  bool write(const Outer& state) {
    StateWriter write({reals, integers});
    write(state);
    real_count = write.reals();
    integer_count = write.integers();
    return write.good();
  }
  [[nodiscard]] bool read(Outer& state) const {
    StateReader read({reals.data(), real_count}, {integers.data(), integer_count});
    read(state);
    return read.complete();
  }
};

double any_bits(SplitMix64& random) { return std::bit_cast<double>(random.next()); }

Outer any_state(SplitMix64& random) {
  Outer state;
  state.colour = static_cast<Colour>(random.below(2));
  state.inner = {random.next(), random.chance(0.5), {any_bits(random), any_bits(random)}};
  state.pose.p = {any_bits(random), -0.0, any_bits(random)};
  state.pose.q = {any_bits(random), 1.0, 2.0, 3.0};
  state.wrench.t = {any_bits(random), 1.0, 2.0};
  for (std::uint64_t k = random.below(5); k > 0; --k) {
    state.few.push_back(static_cast<std::int32_t>(random.next()));
  }
  state.count = static_cast<int>(random.below(4));
  for (int k = 0; k < state.count; ++k) state.some[static_cast<std::size_t>(k)] = any_bits(random);
  return state;
}

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace

TEST_CASE("state read back is the state that was written, to the bit") {
  SplitMix64 random(3);
  for (std::int64_t k = 0; k < scaled(20'000); ++k) {
    const Outer state = any_state(random);
    Paper paper;
    REQUIRE(paper.write(state));
    Outer back;
    REQUIRE(paper.read(back));
    CHECK(back.colour == state.colour);
    CHECK(back.inner.bits == state.inner.bits);
    CHECK(back.inner.on == state.inner.on);
    CHECK(same(back.inner.pair[1], state.inner.pair[1]));
    CHECK(same(back.pose.p.y(), state.pose.p.y()));
    CHECK(same(back.pose.q.w(), state.pose.q.w()));
    CHECK(same(back.wrench.t.x(), state.wrench.t.x()));
    REQUIRE(back.few.size() == state.few.size());
    for (std::size_t i = 0; i < state.few.size(); ++i) CHECK(back.few[i] == state.few[i]);
    REQUIRE(back.count == state.count);
    for (std::size_t i = 0; i < 3; ++i) CHECK(same(back.some[i], state.some[i]));
  }
}

TEST_CASE("a choice, a count or a truth value out of its range is refused") {
  Outer state;
  state.few.push_back(1);
  Paper paper;
  REQUIRE(paper.write(state));
  // In the order of the visit: colour, bits, on, size of few, its element, count.
  REQUIRE(paper.integer_count == 6);
  for (const auto& [place, wrong] : {std::pair<std::size_t, std::int64_t>{0, 2},
                                     {0, -1},
                                     {2, 2},
                                     {3, 5},
                                     {3, -1},
                                     {4, 1LL << 31},
                                     {5, 4},
                                     {5, -1}}) {
    Paper broken = paper;
    broken.integers[place] = wrong;
    Outer back;
    CHECK(!broken.read(back));
  }
  Paper shorter = paper;
  --shorter.real_count;
  Outer back;
  CHECK(!shorter.read(back));
  Paper longer = paper;
  ++longer.integer_count;
  CHECK(!longer.read(back));
}

TEST_CASE("what finds no room is told, and nothing is written beyond it") {
  std::array<double, 3> reals{1.0, 1.0, 1.0};
  std::array<std::int64_t, 64> integers{};
  StateWriter write({std::span(reals).first(2), integers});
  write(Outer{});
  CHECK(!write.good());
  CHECK(reals[2] == 1.0);
}

TEST_CASE("the hash of numbers is FNV-1a over their words and sees every bit") {
  // By hand: one word w from the published offset basis and prime.
  const std::array<std::int64_t, 1> one{0x0123456789ABCDEF};
  const std::uint64_t by_hand = (0xCBF29CE484222325ULL ^ 0x0123456789ABCDEFULL) * 0x100000001B3ULL;
  CHECK(hash_numbers(kStateHashStart, {}, one) == by_hand);
  std::array<double, 4> reals{0.0, 1.0, -2.0, 1e300};
  const std::uint64_t before = hash_numbers(kStateHashStart, reals, one);
  for (double& number : reals) {
    for (unsigned bit = 0; bit < 64; ++bit) {
      const double kept = number;
      number = std::bit_cast<double>(std::bit_cast<std::uint64_t>(number) ^ (1ULL << bit));
      CHECK(hash_numbers(kStateHashStart, reals, one) != before);
      number = kept;
    }
  }
}

}  // namespace hapticd::test
