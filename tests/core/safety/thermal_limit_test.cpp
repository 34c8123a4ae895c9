// Truth: the root mean square over every sliding window, by prefix sums in long double.
#include "core/safety/thermal_limit.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/safety/output_stage.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Largest root mean square over any `window` successive of `sizes`.
double largest_rms(const std::vector<double>& sizes, std::size_t window) {
  std::vector<long double> sums(sizes.size() + 1, 0.0L);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    sums[i + 1] = sums[i] + static_cast<long double>(sizes[i]) * sizes[i];
  }
  long double largest = 0.0L;
  for (std::size_t i = window; i < sums.size(); ++i) {
    largest = std::max(largest, sums[i] - sums[i - window]);
  }
  return static_cast<double>(std::sqrt(largest / static_cast<long double>(window)));
}

std::vector<double> written_forces(double wanted, bool bursts, const SafetyLimits& limits,
                                   std::int64_t ticks) {
  SplitMix64 random(21);
  SafetyState state;
  SafetyInput input;
  input.dt_s = 1e-3;
  input.enable = true;
  input.gain = 1.0;
  std::vector<double> sizes;
  sizes.reserve(static_cast<std::size_t>(ticks));
  bool on = true;
  for (std::int64_t i = 0; i < ticks; ++i) {
    if (bursts && random.chance(0.001)) on = !on;
    input.F_H_D.f = {0, on ? wanted : 0.0, 0};
    sizes.push_back(to_vector(limit(input, limits, state).f_H_D).norm());
  }
  return sizes;
}

SafetyLimits hot() {
  SafetyLimits limits;
  limits.passivity.allowance = 1e9;
  limits.continuous_force = 6.0;
  return limits;
}

}  // namespace

TEST_CASE("over every 10 s the root mean square of what is written stays at the continuous limit") {
  for (const bool bursts : {false, true}) {
    const auto sizes = written_forces(22.0, bursts, hot(), 60'000 + scaled(1'000'000));
    CHECK(largest_rms(sizes, 10'000) <= 6.0 * (1 + 1e-12));
    if (!bursts) CHECK(largest_rms(sizes, 10'000) > 5.7);  // and it is used
  }
}

TEST_CASE("a force below the continuous limit by 2 % is never limited") {
  const auto sizes = written_forces(5.88, false, hot(), 40'000);
  CHECK(*std::min_element(sizes.begin() + 10, sizes.end()) == doctest::Approx(5.88));
}

TEST_CASE("a short peak is free: 22 N for 0.3 s after rest") {
  const auto sizes = written_forces(22.0, false, hot(), 300);
  CHECK(*std::min_element(sizes.begin() + 10, sizes.end()) == doctest::Approx(22.0));
}

TEST_CASE(
    "the limit fades in: no tick takes more than 1 % of the force, and seven tenths of what is "
    "held for ever stay") {
  const auto sizes = written_forces(22.0, false, hot(), 30'000);
  for (std::size_t i = 11; i < sizes.size(); ++i) {
    REQUIRE(sizes[i] >= 0.99 * sizes[i - 1]);
    REQUIRE(sizes[i] >= 0.7 * 6.0);
  }
}

TEST_CASE("the window forgets: after its length without force everything is allowed again") {
  ThermalLoad load;
  for (int k = 0; k < 3000; ++k) add_load(22.0, 1e-3, {6.0, 10.0}, load);
  const double tired = allowed_size({6.0, 10.0}, load);
  add_load(0.0, 10.2, {6.0, 10.0}, load);
  CHECK(tired < 22.0);
  CHECK(allowed_size({6.0, 10.0}, load) ==
        doctest::Approx(6.0 * std::sqrt(0.5 + 5.0 / kThermalHorizon_s)));
}

TEST_CASE("uneven ticks, pauses and blocks of any length are never counted too little") {
  SplitMix64 random(22);
  ThermalLoad load;
  const double window_s = 2.0;
  std::vector<std::array<double, 3>> held;  // end of tick, its length, square of the force
  double now_s = 0.0;
  const std::int64_t count = scaled(100'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const double dt_s = random.chance(0.01) ? random.uniform(0.0, 0.5) : random.uniform(0.0, 0.004);
    const double size = random.uniform(0.0, 20.0);
    add_load(size, dt_s, {5.0, window_s}, load);
    now_s += dt_s;
    held.push_back({now_s, dt_s, std::max(0.0, size * size - 12.5)});
    long double truth = 0.0L;
    for (auto tick = held.rbegin(); tick != held.rend(); ++tick) {
      const double inside = std::min((*tick)[0] - (now_s - window_s), (*tick)[1]);
      if (inside <= 0.0) break;
      truth += static_cast<long double>(inside) * (*tick)[2];
    }
    long double counted = load.current;
    for (const double block : load.blocks) counted += block;
    if (counted < truth * (1 - 1e-9L)) FAIL("forgot too early in tick " << i);
  }
}

}  // namespace hapticd::test
