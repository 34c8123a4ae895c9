// See rendering_fixture.h.
#include "tests/core/contact/rendering_fixture.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/math/rotation.h"

namespace hapticd::test {
namespace {

double smallest_radius(const std::vector<Sphere>& spheres) {
  return std::min_element(spheres.begin(), spheres.end(),
                          [](const Sphere& a, const Sphere& b) { return a.r < b.r; })
      ->r;
}

const StringBend* find_bend(const ContactState& state, std::size_t capsule) {
  for (const TouchedString& hold : state.touched) {
    if (hold.yields && static_cast<std::size_t>(hold.bend.capsule) == capsule) return &hold.bend;
  }
  return nullptr;
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

double RenderingScene::oracle_spacing() const {
  double thinnest = 1.0;
  for (const Capsule& capsule : capsules_W) thinnest = std::min(thinnest, capsule.r);
  for (const auto& body : body_spheres_) thinnest = std::min(thinnest, smallest_radius(body));
  return (smallest_radius(tool_spheres) + thinnest) / 4;
}

long double RenderingScene::true_path_gap(const Pose& X_WF, const Pose& X_WT) const {
  return path_minimum_gap({tool_spheres, X_WF}, {tool_spheres, X_WT}, truth(), oracle_spacing());
}

long double RenderingScene::true_path_gap(const ContactState& from, const ContactState& to) const {
  std::vector<Capsule> straight;
  std::vector<OracleBentString> bent;
  for (std::size_t i = 0; i < capsules_W.size(); ++i) {
    const Capsule& string = capsules_W[i];
    const StringBend* before = find_bend(from, i);
    const StringBend* after = find_bend(to, i);
    if (before == nullptr && after == nullptr) {
      straight.push_back(string);
      continue;
    }
    // A string that is not held is straight: its vertex may stand anywhere on its axis.
    const double lambda_from = before != nullptr ? before->lambda : after->lambda;
    const double lambda_to = after != nullptr ? after->lambda : before->lambda;
    const Vector3 axis = string.p_B - string.p_A;
    bent.push_back({string, string.p_A + lambda_from * axis, string.p_A + lambda_to * axis});
    if (before != nullptr) bent.back().p_WP_from += before->u_W;
    if (after != nullptr) bent.back().p_WP_to += after->u_W;
  }
  const std::vector<Sphere> first = displaced_spheres(from);
  const std::vector<Sphere> last = displaced_spheres(to);
  return path_minimum_gap({first, from.X_WG}, {last, to.X_WG}, {straight, oracle_bodies_, bent},
                          oracle_spacing());
}

std::vector<Sphere> RenderingScene::displaced_spheres(const ContactState& state) const {
  std::vector<Sphere> spheres = tool_spheres;
  for (const SoftPart& soft : state.parts) {
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      const std::int32_t part = part_of_sphere.empty() ? 0 : part_of_sphere[i];
      if (part == soft.part) spheres[i].p += soft.v_G;
    }
  }
  return spheres;
}

const ContactResult& ToolRun::tick(const Pose& X_WH, double dt) {
  asked = input(X_WH, dt);
  problem->solve(asked, state, result);
  return result;
}

long double ToolRun::tick_along(const Pose& X_WH) {
  asked = input(X_WH);
  ContactState before = state;
  problem->begin(asked, state, result);
  if (problem->overlaps()) {
    problem->recover();
    return scene.true_path_gap(before, state);
  }
  long double smallest = std::numeric_limits<long double>::infinity();
  for (bool more = true; more && result.sub_steps < options.sub_steps;) {
    problem->prepare();
    before = state;
    more = problem->advance();
    smallest = std::min(smallest, scene.true_path_gap(before, state));
    more = more && !problem->work_used_up();
  }
  problem->finish();
  return smallest;
}

const ContactResult& ToolRun::hold(const Pose& X_WH, int ticks) {
  for (int i = 0; i < ticks; ++i) tick(X_WH);
  return result;
}

ContactOptions reference_options() {
  ContactOptions options;
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
