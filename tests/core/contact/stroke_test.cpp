// The law: the tool never passes through or sinks into anything. Judged by the exhaustive oracle on
// the committed path, never by the solver's own rows; a control that detects around the haptic pose
// must fail on the same strokes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/core/contact/strokes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Allowed depth of the committed path, m.
constexpr long double kAllowedDepth = 1e-6L;

/// Deepest point of the whole committed path of a stroke (m, negative = penetration).
long double path_gap(const Stroke& stroke, const ContactOptions& options) {
  ToolRun run(stroke.scene, stroke.X_WH.front());
  run.options = options;
  long double deepest = 1.0L;
  for (const Pose& X_WH : stroke.X_WH) deepest = std::min(deepest, run.tick_along(X_WH));
  return deepest;
}

/// The naive algorithm: the same program and rows, but detected around the haptic pose, once per
/// tick.
long double path_gap_detecting_at_h(const Stroke& stroke) {
  ToolRun run(stroke.scene, stroke.X_WH.front());
  const auto contacts = std::make_unique<ContactSet>();
  const auto qp = std::make_unique<QpWorkspace>();
  const auto problem = std::make_unique<QpProblem>();
  QpSolution solution;
  long double deepest = 1.0L;
  for (const Pose& X_WH : stroke.X_WH) {
    const ContactInput input = run.input(X_WH);
    find_contacts({input.tool, X_WH}, input.obstacles, {}, *contacts);
    const PoseError error_GH = coupling_error(run.state.X_WG, X_WH, Vector3::Zero());
    problem->rows = 0;
    problem->unknowns = kToolDof;
    for (std::size_t k = 0; k < 3; ++k) {
      problem->weight[k] = run.stiffness.kt;
      problem->weight[k + 3] = run.stiffness.kr();
      problem->target[k] = error_GH.dp[static_cast<Eigen::Index>(k)];
      problem->target[k + 3] = error_GH.dtheta[static_cast<Eigen::Index>(k)];
    }
    for (const Contact& contact : contacts->contacts) {
      if (problem->rows == kMaxQpRows) break;
      const auto i = static_cast<std::size_t>(problem->rows++);
      const Vector3 angular = (contact.p_WC - X_WH.p).cross(contact.nhat_OG_W);
      for (std::size_t k = 0; k < 3; ++k) {
        problem->row[k][i] = contact.nhat_OG_W[static_cast<Eigen::Index>(k)];
        problem->row[k + 3][i] = angular[static_cast<Eigen::Index>(k)];
      }
      // Linearised at h: gap(h) + row . (x - e) >= 0.
      problem->bound[i] =
          contact.nhat_OG_W.dot(error_GH.dp) + angular.dot(error_GH.dtheta) - contact.gap;
    }
    solve_qp(*problem, QpWarmStart{}, *qp, solution);
    if (solution.status != QpStatus::kOptimal) continue;
    const Pose X_before = run.state.X_WG;
    run.state.X_WG = moved(X_before, {{solution.x[0], solution.x[1], solution.x[2]},
                                      {solution.x[3], solution.x[4], solution.x[5]}});
    deepest = std::min(deepest, stroke.scene.true_path_gap(X_before, run.state.X_WG));
  }
  return deepest;
}

}  // namespace

TEST_CASE(
    "no stroke of any kind from 0.1 to 100 m/s sinks in or passes through by more than a "
    "micrometre") {
  const std::int64_t strokes = scaled(100'000);
  long double deepest = 1.0L;
  for (std::int64_t i = 0; i < strokes; ++i) {
    const Stroke stroke = make_stroke(static_cast<std::uint64_t>(i));
    const long double gap = path_gap(stroke, ContactOptions{});
    deepest = std::min(deepest, gap);
    if (gap < -kAllowedDepth)
      FAIL_CHECK("stroke " << i << ": " << static_cast<double>(gap) << " m, " << stroke.describe());
  }
  MESSAGE("deepest point of " << strokes << " committed paths: " << static_cast<double>(deepest)
                              << " m");
  CHECK(deepest >= -kAllowedDepth);
}

TEST_CASE(
    "detection around the haptic pose does pass through on the same strokes, so the strokes are "
    "strong enough") {
  constexpr int kDecades = 3;
  int strokes[kDecades] = {};
  int failed[kDecades] = {};
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(scaled(10'000)) + 100; ++i) {
    const Stroke stroke = make_stroke(i);
    const auto decade =
        static_cast<std::size_t>(std::clamp(std::log10(stroke.speed * 10.0), 0.0, 2.999));
    ++strokes[decade];
    if (path_gap_detecting_at_h(stroke) < -kAllowedDepth) ++failed[decade];
  }
  for (std::size_t decade = 0; decade < kDecades; ++decade) {
    CAPTURE(decade);
    CHECK(strokes[decade] > 10);
    CHECK(failed[decade] > strokes[decade] / 10);
  }
}

TEST_CASE("every number of sub-steps is safe, one included") {
  for (const int sub_steps : {1, 2, 4, 16, 64}) {
    ContactOptions options;
    options.sub_steps = sub_steps;
    for (std::int64_t i = 0; i < scaled(2'000); ++i) {
      const Stroke stroke = make_stroke(static_cast<std::uint64_t>(1'000'000 + i));
      CAPTURE(sub_steps);
      CAPTURE(stroke.describe());
      REQUIRE(path_gap(stroke, options) >= -kAllowedDepth);
    }
  }
}

TEST_CASE("coarser levels of the trees may feel fatter but never sink in") {
  for (const int level : {1, 2}) {
    ContactOptions options;
    options.tool_level = level;
    options.body_level = level;
    for (std::int64_t i = 0; i < scaled(5'000); ++i) {
      const Stroke stroke = make_stroke(static_cast<std::uint64_t>(2'000'000 + i));
      CAPTURE(level);
      CAPTURE(stroke.describe());
      REQUIRE(path_gap(stroke, options) >= -kAllowedDepth);
    }
  }
}

}  // namespace hapticd::test
