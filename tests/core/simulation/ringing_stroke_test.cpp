// The law for strings that ring: strokes through the whole tick, among strings that an earlier pass
// has plucked. The contact problem must not know of the vibration: every committed configuration
// has the bits it has among silent strings, so the oracle judges the way of tool and string
// sub-step by sub-step on the contact problem alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>

#include "core/scene/owned_simulation.h"
#include "tests/core/contact/strokes.h"
#include "tests/support/scale.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

/// Allowed depth of the committed path, m.
constexpr long double kAllowedDepth = 1e-6L;

/// What one stroke did.
struct StrokeReport {
  long double gap = 1.0L;    ///< deepest point of the committed path, m; negative: penetration
  bool same = true;          ///< every configuration has the bits it has among silent strings
  bool finite = true;        ///< the wrench of every tick is, and within the limits
  std::int64_t ringing = 0;  ///< ticks with a string that rings
  std::int64_t struck = 0;   ///< ticks with a vibration force
  std::int64_t releases = 0;
};

/// Tunes a string as if it had been asked for.
void tune(StringConstants& string, double frequency) {
  if (!(string.tension > 0.0) || !(string.length > 0.0)) return;
  string.frequency = frequency;
  const double mu = string.tension / (4.0 * string.length * string.length * frequency * frequency);
  string.modal_mass = 0.5 * mu * string.length;
}

bool same_bits(const ContactState& a, const ContactState& b) {
  bool same = a.X_WG.p == b.X_WG.p && a.X_WG.q.coeffs() == b.X_WG.q.coeffs() &&
              a.touched.size() == b.touched.size() && a.F_H_W.f == b.F_H_W.f;
  for (std::size_t k = 0; same && k < a.touched.size(); ++k) {
    same = a.touched[k].bend.u_W == b.touched[k].bend.u_W &&
           a.touched[k].bend.lambda == b.touched[k].bend.lambda;
  }
  return same;
}

StrokeReport play(Stroke& stroke, int modes) {
  double frequency = 65.4;
  for (StringConstants& string : stroke.scene.strings) tune(string, frequency *= 1.2);
  stroke.scene.instrument.modes = modes;
  // Faster than usual, so that the string rings for many of the few ticks.
  stroke.scene.instrument.release.arm_deflection = 0.05e-3;
  ToolRun run(stroke.scene, stroke.X_WH.front());
  const ContactInput input = run.input(stroke.X_WH.front());
  ToolScene scene;
  scene.tool = input.tool;
  scene.obstacles = input.obstacles;
  scene.strings = stroke.scene.strings;
  scene.instrument = stroke.scene.instrument;
  const OwnedSimulation play = own_simulation({&scene, 1});
  const auto& simulation = play.simulation;
  SimulationTick output;

  StrokeReport report;
  // The first pass plucks; back in one jump; the second pass is judged.
  const std::size_t pass = stroke.X_WH.size();
  std::int64_t t_ns = 0;
  for (std::size_t k = 0; k < 2 * pass; ++k) {
    const Pose& X_WH = stroke.X_WH[k % pass];
    output.step(*simulation, {t_ns += 1'000'000, to_array(X_WH.p), to_array(X_WH.q)});
    if (k == 0) run.state.X_WG = output.tool(0).X_WH;
    if (k < pass) {
      run.tick(output.tool(0).X_WH);
    } else {
      report.gap = std::min(report.gap, run.tick_along(output.tool(0).X_WH));
    }
    report.same = report.same && same_bits(run.state, simulation->memory().tools[0].state.contact);
    const Wrench& F = output.tool(0).F_H_W;
    report.finite = report.finite && F.f.norm() <= scene.limits.force * (1.0 + 1e-12) &&
                    F.t.norm() <= scene.limits.torque * (1.0 + 1e-12) &&
                    output.tool(0).F_computed_H_W.f.allFinite();
    for (const StringTick& reading : output.strings()) {
      if (reading.phase >= StringPhase::kFundamental) ++report.ringing;
      if (reading.vibration_force != 0.0) ++report.struck;
    }
    for (const StringEvent& event : output.events()) {
      report.releases += event.kind == StringEventKind::kRelease ? 1 : 0;
    }
  }
  return report;
}

}  // namespace

TEST_CASE(
    "no stroke among ringing strings sinks in by more than a micrometre, and no vibration changes "
    "a "
    "bit of where the tool is") {
  const std::int64_t strokes = scaled(100'000);
  long double deepest = 1.0L;
  StrokeReport all;
  for (std::int64_t i = 0; i < strokes; ++i) {
    Stroke stroke = make_string_stroke(static_cast<std::uint64_t>(i) + 500'000);
    const StrokeReport report = play(stroke, i % 4 == 0 ? 8 : 0);
    deepest = std::min(deepest, report.gap);
    all.ringing += report.ringing;
    all.struck += report.struck;
    all.releases += report.releases;
    if (report.gap < -kAllowedDepth || !report.same || !report.finite) {
      FAIL_CHECK("stroke " << i << ": " << static_cast<double>(report.gap) << " m, same "
                           << report.same << ", finite " << report.finite << ", "
                           << stroke.describe());
    }
  }
  MESSAGE("deepest point of " << strokes << " committed paths: " << static_cast<double>(deepest)
                              << " m; " << all.releases << " releases, " << all.ringing
                              << " ticks ringing, " << all.struck << " struck");
  CHECK(deepest >= -kAllowedDepth);
  CHECK(all.ringing >= strokes / 2);
}

}  // namespace hapticd::test
