// The energy guard of a step. Truth: the coupling energy before and after, and what pressing the
// touched pairs back onto their obstacles would release, both computed here from poses and
// multipliers.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/core/contact/strokes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Of a gap, m.
constexpr double kRounding = 1e-12;

/// Multiplier times gap, over the pairs that carry force in the last linearisation, J.
double released_by_pressing_back(const ToolRun& run) {
  double energy = 0.0;
  for (int k = 0; k < run.result.active_count; ++k) {
    const ActiveContact& active = run.result.active[static_cast<std::size_t>(k)];
    const ContactKey& key =
        run.problem->candidates().contacts().contacts[static_cast<std::size_t>(active.contact)].key;
    const Contact now =
        evaluate_contact(key, {run.scene.tool(), run.state.X_WG}, run.scene.obstacles());
    energy += active.multiplier * std::max(0.0, now.gap);
  }
  return energy;
}

}  // namespace

TEST_CASE("no linearisation lets the coupling energy climb beyond what pressing back releases") {
  int judged = 0;
  int nearer = 0;
  for (std::int64_t i = 0; i < scaled(6'000) + 300; ++i) {
    const Stroke stroke = make_stroke(static_cast<std::uint64_t>(5'000'000 + i));
    CAPTURE(stroke.describe());
    ToolRun run(stroke.scene, stroke.X_WH.front());
    run.options.sub_steps = 1;
    for (const Pose& X_WH : stroke.X_WH) {
      // What wins back clearance costs energy: all ticks keep the same, and those count that begin
      // with it.
      run.state.clearance = run.options.skin;
      const bool clear = stroke.scene.true_gap(run.state.X_WG) >= run.options.skin - kRounding;
      const PoseError error_GH = coupling_error(run.state.X_WG, X_WH, run.state.phi_GH_W);
      const double before = coupling_energy(run.stiffness, X_WH.q, error_GH);
      run.asked = run.input(X_WH);
      run.problem->begin(run.asked, run.state, run.result);
      REQUIRE(!run.problem->overlaps());
      run.problem->advance();
      const PoseError e_after = coupling_error(run.state.X_WG, X_WH, error_GH.dtheta);
      const double after = coupling_energy(run.stiffness, X_WH.q, e_after);
      ++(clear ? judged : nearer);
      if (clear) REQUIRE(after - released_by_pressing_back(run) <= before * (1 + 1e-12));
      run.problem->finish();
    }
  }
  CHECK(judged > 2 * nearer);
}

}  // namespace hapticd::test
