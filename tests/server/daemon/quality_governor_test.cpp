// The governor of quality against machines that are made up: each level costs so much, time passes
// as told. Truth: which level fits is known, since the costs are ours.
#include "server/daemon/quality_governor.h"

#include <doctest/doctest.h>

#include <array>
#include <functional>

namespace hapticd::test {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// Budget of a tick, ns.
constexpr std::int64_t kBudget_ns = 500'000;

using Costs = std::array<std::int64_t, kQualityLevels>;

/// A daemon that obeys at once, but whose cost is told one tick late, as the loop tells it.
struct Machine {
  std::function<std::int64_t(int level, std::int64_t t_ns)> cost;
  QualityGovernor governor;
  int level = kDefaultQuality;
  std::int64_t t_ns = 0;
  std::int64_t last_ns = 0;
  int changes = 0;

  explicit Machine(const Costs& costs)
      : cost([costs](int at, std::int64_t) { return costs[static_cast<std::size_t>(at)]; }) {}

  void run(std::int64_t duration_ns) {
    for (const std::int64_t end_ns = t_ns + duration_ns; t_ns < end_ns; t_ns += kTick_ns) {
      const int wanted = govern({t_ns, last_ns, level}, kBudget_ns, governor);
      if (wanted != level) ++changes;
      CHECK(std::abs(wanted - level) <= 1);
      level = wanted;
      last_ns = cost(level, t_ns);
    }
  }
};

TEST_CASE("it comes to the highest level whose cost has room, from above and from below") {
  Machine cheap({10'000, 20'000, 30'000, 40'000, 50'000});
  cheap.run(10 * kSecond_ns);
  CHECK(cheap.level == 4);
  CHECK(cheap.governor.reason == QualityReason::kRoom);
  CHECK(cheap.changes == 1);
  Machine dear({100'000, 200'000, 700'000, 900'000, 1'000'000});
  dear.run(kSecond_ns);
  CHECK(dear.level == 1);
  CHECK(dear.changes == 2);
}

TEST_CASE("it stays where the next level would not fit, and does not swing") {
  Machine machine({50'000, 100'000, 150'000, 200'000, 600'000});
  machine.run(600 * kSecond_ns);
  CHECK(machine.level == 3);
  // Tried after 2, 12, 32, 72, 152 and 312 s, and taken back each time.
  CHECK(machine.changes <= 2 * 6);
  CHECK(machine.changes >= 4);
}

TEST_CASE("between room and budget it neither climbs nor descends") {
  for (const std::int64_t cost : {305'000L, 400'000L, 500'000L}) {
    Machine machine({cost, cost, cost, cost, cost});
    machine.run(60 * kSecond_ns);
    CHECK(machine.changes == 0);
    CHECK(machine.governor.reason == QualityReason::kBudget);
  }
}

TEST_CASE("a load that comes is answered within 20 ms of ticks, one that goes after a calm time") {
  Machine machine({50'000, 100'000, 150'000, 200'000, 250'000});
  machine.run(5 * kSecond_ns);
  CHECK(machine.level == 4);
  const auto light = machine.cost;
  machine.cost = [](int level, std::int64_t) { return 260'000L * (level + 1); };
  machine.run(20 * kTick_ns);
  CHECK(machine.level == 3);
  CHECK(machine.governor.reason == QualityReason::kBudget);
  machine.run(2 * kSecond_ns);
  CHECK(machine.level == 0);
  machine.cost = light;
  machine.run(kSecond_ns);
  CHECK(machine.level == 0);
  machine.run(60 * kSecond_ns);
  CHECK(machine.level == 4);
}

TEST_CASE("while a level that was too much waits for its next try it says so") {
  Machine machine({50'000, 100'000, 150'000, 600'000, 700'000});
  machine.run(5 * kSecond_ns);
  CHECK(machine.level == 2);
  CHECK(machine.governor.reason == QualityReason::kSettling);
}

TEST_CASE("rare expensive ticks change nothing: one in 200 over a quarter of an hour") {
  Machine machine({100'000, 100'000, 100'000, 100'000, 100'000});
  machine.cost = [&](int, std::int64_t t_ns) {
    return t_ns / kTick_ns % 200 == 0 ? 3'000'000L : 100'000L;
  };
  machine.run(900 * kSecond_ns);
  CHECK(machine.level == 4);
  CHECK(machine.changes == 1);
}

TEST_CASE("without measured times it does not move, and below level 0 there is nothing") {
  Machine blind({0, 0, 0, 0, 0});
  blind.run(20 * kSecond_ns);
  CHECK(blind.changes == 0);
  CHECK(blind.governor.reason == QualityReason::kSettling);
  Machine hopeless({900'000, 900'000, 900'000, 900'000, 900'000});
  hopeless.run(20 * kSecond_ns);
  CHECK(hopeless.level == 0);
  CHECK(hopeless.governor.reason == QualityReason::kBudget);
}

TEST_CASE("ticks that a work budget cuts short, within the time, neither descend nor climb") {
  for (const bool cut_short : {true, false}) {
    QualityGovernor governor;
    int level = 3;
    for (std::int64_t t_ns = 0; t_ns < 20 * kSecond_ns; t_ns += kTick_ns) {
      level = govern({t_ns, kBudget_ns / 2, level, cut_short}, kBudget_ns, governor);
    }
    CHECK(level == (cut_short ? 3 : 4));
    CHECK((governor.reason == QualityReason::kBudget) == cut_short);
  }
}

TEST_CASE("ticks of the level before, still on their way, are not held against the new one") {
  QualityGovernor governor;
  std::int64_t t_ns = 0;
  int level = 3;
  while (level == 3) level = govern({t_ns += kTick_ns, 800'000, 3}, kBudget_ns, governor);
  CHECK(level == 2);
  for (int k = 0; k < 2000; ++k) {
    CHECK(govern({t_ns += kTick_ns, 800'000, 3}, kBudget_ns, governor) == 2);
  }
}

}  // namespace
}  // namespace hapticd::test
