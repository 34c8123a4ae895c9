// The preset `paper` keeps Eq. 10 as printed, whose force has no potential: a finger that presses
// at the middle, glides to an end, lifts and goes back gains energy in every lap. What the output
// stage makes of it: it fades, and nobody draws more than 5 mJ. Truth: the energy integral in long
// double, and the ratio of what is written to what is asked for.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/safety/output_stage.h"
#include "tests/scenario/shipped_scene.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

constexpr double kTick_s = 1e-3;
/// The law of the port, J.
constexpr long double kBound = 5e-3L;
/// By how much the correction may change the force in 10 ms while half of the reserve is left.
constexpr double kSmooth = 0.05;
/// And by how much of what is asked for it may fall in 2 ms, whatever is left.
constexpr double kVanishing = 0.1;
/// Forces smaller than this have no ratio, N.
constexpr double kSmall = 0.02;

/// Press `depth` at x = 0, glide to the end, lift, go back through the air: one row per tick.
std::vector<Vector3> lap(double depth, double speed) {
  constexpr double kSurface = 0.0054;
  const Vector3 corners[] = {{0.0, kSurface + 1e-3, 0.0},
                             {0.0, kSurface - depth, 0.0},
                             {-0.495, kSurface - depth, 0.0},
                             {-0.495, kSurface + 1e-3, 0.0},
                             {0.0, kSurface + 1e-3, 0.0}};
  std::vector<Vector3> rows;
  for (int k = 0; k < 4; ++k) {
    const Vector3 way = corners[k + 1] - corners[k];
    const double pace = k % 2 == 0 ? 0.03 : speed;
    const int ticks = static_cast<int>(way.norm() / (pace * kTick_s));
    for (int i = 1; i <= ticks; ++i) rows.push_back(corners[k] + way * (1.0 * i / ticks));
  }
  return rows;
}

/// What the port gave, and how its correction went.
struct Port {
  long double given = 0.0L;  ///< less what the device's damping repaid of it, J
  long double most = 0.0L;   ///< largest of it, J
  double computed = 0.0;     ///< work that the forces asked for would have done, J
  double steepest = 0.0;     ///< change of the ratio in 10 ms while half of the reserve is left
  double vanished = 0.0;     ///< largest fall of the ratio in 2 ms
};

/// `laps` laps of the hand, with the output stage of a device with damping 1 N s/m.
Port play(const std::vector<Vector3>& way, int laps) {
  LoadOptions options = shipped();
  options.preset = v1::PRESET_PAPER;
  const LoadResult result = load_scene("single_string", options);
  REQUIRE(result.loaded != nullptr);
  const OwnedSimulation scene = result.loaded->scene->simulate();
  SimulationTick output;
  const SafetyLimits limits;
  SafetyState state;
  Port port;
  std::vector<double> ratio;
  std::vector<bool> judged;
  Vector3 before = way.back();
  Vector3 asked_before = Vector3::Zero();
  std::int64_t t_ns = 0;
  for (int k = 0; k < laps; ++k) {
    for (const Vector3& p_WH : way) {
      t_ns += 1'000'000;
      output.step(*scene.simulation, {t_ns, to_array(p_WH), {1.0, 0.0, 0.0, 0.0}});
      const Vector3 asked = output.tool(0).F_computed_H_W.f;
      const Vector3 dx = p_WH - before;
      SafetyInput input;
      input.now_ns = t_ns;
      input.dt_s = kTick_s;
      input.enable = true;
      input.gain = 1.0;
      input.F_H_D.f = asked;
      input.V_DH_D.v = dx / kTick_s;
      input.displacement_D.v = dx;
      const Vector3 held = to_vector(state.f_H_D);
      port.given += static_cast<long double>(held.dot(dx));
      const double repaid = limits.passivity.damping * dx.squaredNorm() / kTick_s;
      if (port.given > 0.0L) {
        port.given = std::max(0.0L, port.given - static_cast<long double>(repaid));
      }
      port.most = std::max(port.most, port.given);
      port.computed += 0.5 * (asked + asked_before).dot(dx);
      const SafetyOutput out = limit(input, limits, state);
      const bool worth = asked.norm() > kSmall;
      ratio.push_back(worth ? to_vector(out.f_H_D).norm() / asked.norm() : 1.0);
      judged.push_back(worth && (out.flags & kSafetySlew) == 0 &&
                       state.port.given < 0.5 * limits.passivity.allowance);
      const std::size_t n = ratio.size();
      if (n > 2) port.vanished = std::max(port.vanished, ratio[n - 3] - ratio[n - 1]);
      before = p_WH;
      asked_before = asked;
    }
  }
  for (std::size_t k = 10; k < ratio.size(); ++k) {
    const auto from = judged.begin() + static_cast<std::ptrdiff_t>(k) - 10;
    if (std::find(from, from + 11, false) != from + 11) continue;
    port.steepest = std::max(port.steepest, std::abs(ratio[k] / ratio[k - 10] - 1.0));
  }
  return port;
}

}  // namespace

TEST_CASE("the preset paper gives energy lap by lap, and its force fades instead of vanishing") {
  for (const double speed : {0.05, 0.15, 0.5}) {
    for (const double depth : {2e-3, 4e-3}) {
      CAPTURE(speed);
      CAPTURE(depth);
      const Port port = play(lap(depth, speed), 5);
      MESSAGE(depth << " m deep, " << speed << " m/s: asked for " << 1e3 * port.computed
                    << " mJ, gave " << 1e3 * static_cast<double>(port.most)
                    << " mJ at most, steepest " << 100.0 * port.steepest
                    << " % in 10 ms, largest fall in 2 ms " << port.vanished);
      CHECK(port.computed > 1e-3);
      CHECK(port.most > 0.5e-3L);
      CHECK(port.most <= kBound);
      CHECK(port.steepest <= kSmooth);
      CHECK(port.vanished <= kVanishing);
    }
  }
}

}  // namespace hapticd::test
