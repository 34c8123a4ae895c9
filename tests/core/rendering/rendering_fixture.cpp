// See rendering_fixture.h.
#include "tests/core/rendering/rendering_fixture.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/math/rotation.h"
#include "core/rendering/recovery.h"

namespace hapticd::test {
namespace {

double smallest_radius(const std::vector<Sphere>& spheres) {
  return std::min_element(spheres.begin(), spheres.end(),
                          [](const Sphere& a, const Sphere& b) { return a.r < b.r; })
      ->r;
}

}  // namespace

RenderingScene::RenderingScene(std::vector<Sphere> spheres)
    : tool_spheres(std::move(spheres)), tool_tree_(build_sphere_tree(tool_spheres)) {}

void RenderingScene::add_body(std::vector<Sphere> spheres, const Pose& X_WB) {
  body_trees_.push_back(build_sphere_tree(spheres));
  body_spheres_.push_back(std::move(spheres));
  bodies_.push_back({body_trees_.back().view(), X_WB});
  oracle_bodies_.push_back({body_spheres_.back(), X_WB});
}

long double RenderingScene::true_gap(const Pose& X_WG) const {
  return exhaustive_minimum_gap(tool_spheres, X_WG, truth());
}

long double RenderingScene::true_path_gap(const Pose& X_WF, const Pose& X_WT) const {
  double thinnest = 1.0;
  for (const Capsule& capsule : capsules_W) thinnest = std::min(thinnest, capsule.r);
  for (const auto& body : body_spheres_) thinnest = std::min(thinnest, smallest_radius(body));
  const double spacing = (smallest_radius(tool_spheres) + thinnest) / 4;
  return path_minimum_gap(tool_spheres, X_WF, X_WT, truth(), spacing);
}

const OptimiserResult& ToolRun::tick(const Pose& X_WH) {
  optimise_configuration(input(X_WH), state, *workspace, result);
  return result;
}

long double ToolRun::tick_along(const Pose& X_WH) {
  const OptimiserInput in = input(X_WH);
  Pose X_before = state.X_WG;
  start_tick(in, state, *workspace, result);
  if (workspace->contacts.minimum_gap < 0.0) {
    recover(in, state, *workspace, result);
    return scene.true_path_gap(X_before, state.X_WG);
  }
  long double smallest = std::numeric_limits<long double>::infinity();
  for (bool more = true; more && result.sub_steps < options.sub_steps; X_before = state.X_WG) {
    more = advance_sub_step(in, state, *workspace, result);
    smallest = std::min(smallest, scene.true_path_gap(X_before, state.X_WG));
  }
  return smallest;
}

const OptimiserResult& ToolRun::hold(const Pose& X_WH, int ticks) {
  for (int i = 0; i < ticks; ++i) tick(X_WH);
  return result;
}

OptimiserOptions reference_options() {
  OptimiserOptions options;
  options.sub_steps = 400;
  options.rotation_step = 4e-3;
  options.stop_tolerance = 1e-10;
  return options;
}

Pose pose_at(const Vector3& p, const Vector3& phi) { return {exp_rotation(phi), p}; }

Pose between(const Pose& X_from, const Pose& X_to, double s) {
  const Vector3 phi = log_rotation(X_to.q * X_from.q.conjugate());
  return {renormalised(exp_rotation(s * phi) * X_from.q), X_from.p + s * (X_to.p - X_from.p)};
}

}  // namespace hapticd::test
