// What is owed is paid by a wrench that fades, and never in steps.
#include "core/safety/energy_debt.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/safety/output_stage.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kTick_s = 1e-3;
/// By how much the factor may change in 10 ms.
constexpr double kSmooth = 0.05;

}  // namespace

TEST_CASE("the factor changes by less than 5 % in 10 ms, whatever is owed and given") {
  SplitMix64 random(81);
  double share = 1.0;
  std::vector<double> shares;
  EnergyDebt debt;
  double lowest = 1.0;
  for (std::int64_t k = 0; k < scaled(1'000'000); ++k) {
    if (random.chance(0.01)) debt = {random.uniform(-0.5, 4e-3), 4e-3, random.chance(0.7)};
    if (random.chance(0.01)) debt.owed = random.uniform(0.0, 4e-3);
    share = paying_share(debt, kTick_s, share);
    shares.push_back(share);
    lowest = std::min(lowest, share);
    REQUIRE(share > 0.0);
    REQUIRE(share <= 1.0);
    const std::size_t n = shares.size();
    if (n > 10) REQUIRE(std::abs(share / shares[n - 11] - 1.0) < kSmooth);
  }
  CHECK(lowest < 0.5);
}

TEST_CASE("nothing fades while less than 0.3 of the allowance is owed, and what faded comes back") {
  CHECK(paying_share({1.19e-3, 4e-3, true}, kTick_s, 1.0) == 1.0);
  CHECK(paying_share({1.21e-3, 4e-3, true}, kTick_s, 1.0) < 1.0);
  // While the hand puts in, though more is owed.
  CHECK(paying_share({3e-3, 4e-3, false}, kTick_s, 0.5) > 0.5);
  double share = 0.1;
  int ticks = 0;
  while (share < 1.0 && ticks < 1000) {
    share = paying_share({0.0, 4e-3, true}, kTick_s, share);
    ++ticks;
  }
  // ln 10 / 4.8 per s.
  CHECK(ticks == within(480, 0.02));
}

TEST_CASE("a force without a potential is felt to fade: a hand that draws 3 mJ meets no step") {
  SafetyLimits limits;
  SafetyState state;
  SafetyInput input;
  input.dt_s = kTick_s;
  input.enable = true;
  input.gain = 1.0;
  input.F_H_D.f = {2.0, 0.0, 0.0};
  input.V_DH_D.v = {0.02, 0.0, 0.0};
  input.displacement_D.v = {2e-5, 0.0, 0.0};
  // It gives 40 uJ a tick at first.
  std::vector<double> written;
  for (int k = 0; k < 400; ++k) {
    written.push_back(limit(input, limits, state).f_H_D[0]);
    const double left = limits.passivity.allowance - state.port.given;
    const std::size_t n = written.size();
    if (n > 10 && left > 0.5 * limits.passivity.allowance) {
      REQUIRE(std::abs(written[n - 1] / written[n - 11] - 1.0) < kSmooth);
    }
  }
  CHECK(written.front() == 2.0);
  CHECK(written.back() < 1.0);
}

}  // namespace hapticd::test
