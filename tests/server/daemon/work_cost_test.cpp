// What work is allowed to cost, against machines that are made up: a tick takes a known time
// without contact, a known one per unit of work, and noise. Truth: what fits is known, since the
// prices are ours.
#include "server/daemon/work_cost.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/contact/tick_work.h"
#include "tests/support/random.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kBudget_ns = 200'000.0;

/// A machine and a scene that asks for more work than fits in most of its contacts.
struct Machine {
  double idle_ns = 5'000.0;
  double unit_ns = kNominalWork_ns;
  double noise = 0.05;            ///< greatest share by which a unit is dearer
  int interrupt_every = 1 << 30;  ///< ticks; one takes 3 ms more
  double late_ns = 0.0;           ///< one tick in 30 takes up to so much more
  double idle_work = 600.0;
  double budget_ns = kBudget_ns;
  double most_work = 4.0;  ///< asked for, of what fits
  SplitMix64 random{5};
  WorkCost price;
  std::int64_t allowed = 0;
  std::int64_t tick = 0;
  std::vector<double> costs{};      ///< ns
  std::vector<double> cut_costs{};  ///< of the ticks that were cut short

  /// As the daemon goes: what a tick cost is told one tick late, and telling takes another.
  void run(int ticks) {
    costs.clear();
    cut_costs.clear();
    PricedTick before;
    for (int k = 0; k < ticks; ++k, ++tick) {
      const std::int64_t told = affordable_work(budget_ns, price);
      const double fits = (budget_ns - idle_ns) / unit_ns;
      // Contact comes and goes; the last linearisation leaves up to a tenth of the work unused.
      const bool touches = tick / 500 % 2 == 1;
      const double wanted = touches ? random.uniform(0.05, most_work) * fits : idle_work;
      const bool cut = allowed > 0 && wanted > static_cast<double>(allowed);
      const double work = cut ? static_cast<double>(allowed) * random.uniform(0.9, 1.0) : wanted;
      const double cost = idle_ns + work * unit_ns * (1.0 + noise * random.uniform(-1.0, 1.0)) +
                          (tick % interrupt_every == 77 ? 3e6 : 0.0) +
                          (tick % 30 == 7 ? late_ns * random.uniform(0.0, 1.0) : 0.0);
      costs.push_back(cost);
      if (cut) cut_costs.push_back(cost);
      learn(before, price);
      before = {std::llround(cost), std::llround(work)};
      if (worth_telling(told, allowed)) allowed = told;
    }
  }
};

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

TEST_CASE("99.9 of 100 ticks stay within 1.1 of the budget on machines of any speed and noise") {
  for (const double unit_ns : {0.2, 1.4, 5.0, 20.0}) {
    for (const double noise : {0.0, 0.05, 0.2}) {
      for (const double idle_ns : {500.0, 20'000.0}) {
        CAPTURE(unit_ns);
        CAPTURE(noise);
        CAPTURE(idle_ns);
        Machine machine;
        machine.unit_ns = unit_ns;
        machine.noise = noise;
        machine.idle_ns = idle_ns;
        machine.run(60'000);
        CHECK(quantile(machine.costs, 0.999) <= 1.1 * kBudget_ns);
        // And it spends what it has.
        REQUIRE(machine.cut_costs.size() > 10'000);
        CHECK(quantile(machine.cut_costs, 0.5) >= 0.7 * kBudget_ns);
      }
    }
  }
}

TEST_CASE("a level is judged by the time of its ticks less what the machine adds in the air, too") {
  Machine machine;
  machine.noise = 0.0;
  machine.late_ns = 100'000.0;
  machine.run(60'000);
  // A third of what fits, as long as it takes, and held up.
  const double work = (kBudget_ns - machine.idle_ns) / machine.unit_ns / 3.0;
  const double own_ns = machine.idle_ns + work * machine.unit_ns;
  const auto judged = [&](double held_up_ns) {
    const PricedTick tick{std::llround(own_ns + held_up_ns), std::llround(work)};
    return static_cast<double>(judged_cost(tick, machine.price));
  };
  CHECK(judged(0.0) == within(own_ns, 1e-3));
  CHECK(judged(90'000.0) == within(own_ns, 0.1));
  CHECK(judged(3e6) == within(own_ns + 2.9e6, 1e-2));
  CHECK(judged_cost({0, 10'000}, machine.price) == 0);
  // Nothing learnt: all is taken at its time.
  CHECK(judged_cost({3'000'000, 10'000}, WorkCost{}) == 3'000'000);
}

TEST_CASE(
    "a machine that becomes less than half as fast is followed, and one that recovers is used "
    "again") {
  Machine machine;
  machine.run(30'000);
  machine.unit_ns *= 2.5;
  machine.run(30'000);
  CHECK(quantile(machine.costs, 0.999) <= 1.1 * kBudget_ns);
  machine.unit_ns /= 2.5;
  machine.run(30'000);
  CHECK(quantile(machine.costs, 0.999) <= 1.1 * kBudget_ns);
  machine.run(2'000);
  CHECK(quantile(machine.cut_costs, 0.5) >= 0.7 * kBudget_ns);
}

TEST_CASE("interrupts are no price of work") {
  Machine quiet;
  quiet.run(30'000);
  Machine machine;
  machine.interrupt_every = 200;
  machine.run(30'000);
  CHECK(static_cast<double>(machine.allowed) > 0.9 * static_cast<double>(quiet.allowed));
}

TEST_CASE("what the machine adds to ticks in the air, too, is no price of work") {
  for (const double late_ns : {20'000.0, 100'000.0, 400'000.0}) {
    CAPTURE(late_ns);
    Machine machine;
    machine.idle_ns = 50'000.0;
    machine.idle_work = 1400.0;
    machine.budget_ns = 120'000.0;
    machine.late_ns = late_ns;
    machine.run(30'000);
    const double fits = (machine.budget_ns - machine.idle_ns) / machine.unit_ns;
    CHECK(static_cast<double>(machine.allowed) > 0.5 * fits);
    CHECK(static_cast<double>(machine.allowed) < fits);
  }
}

TEST_CASE("after a contact that lasted the first ticks in the air say what a tick costs without") {
  WorkCost price;
  for (int k = 0; k < 10'000; ++k) learn({300'000, 50'000}, price);
  // Dearer than the budget: its share is what fits.
  const auto pressed = static_cast<double>(affordable_work(kBudget_ns, price));
  CHECK(pressed == within(50'000.0 * 0.95 * 200.0 / 300.0, 1e-3));
  for (int k = 0; k < 3; ++k) learn({20'000, 1'400}, price);
  const auto fits = static_cast<double>(affordable_work(kBudget_ns, price));
  CHECK(fits > (kBudget_ns - 20'000.0) / (4.0 * kNominalWork_ns) * 0.9);
}

TEST_CASE("before anything is known it allows what a machine four times slower can do") {
  WorkCost price;
  const auto first = static_cast<double>(affordable_work(kBudget_ns, price));
  CHECK(first * 4.0 * kNominalWork_ns <= kBudget_ns);
  CHECK(first * 4.0 * kNominalWork_ns >= 0.9 * kBudget_ns);
}

TEST_CASE("without measured times nothing is learnt, and the nominal price needs none") {
  WorkCost price;
  const std::int64_t first = affordable_work(kBudget_ns, price);
  for (int k = 0; k < 1000; ++k) learn({0, 50'000}, price);
  CHECK(affordable_work(kBudget_ns, price) == first);
  learn({1'000'000'000, 50'000}, price);
  CHECK(nominal_work(1400.0) == 1020);
  CHECK(nominal_work(1e-9) == 1);
}

TEST_CASE("only a change of more than a part in 64 is told, and always the end of a bound") {
  CHECK(worth_telling(1000, 0));
  CHECK(worth_telling(0, 1000));
  CHECK_FALSE(worth_telling(0, 0));
  CHECK_FALSE(worth_telling(1010, 1000));
  CHECK(worth_telling(1020, 1000));
  CHECK(worth_telling(980, 1000));
}

}  // namespace hapticd::test
