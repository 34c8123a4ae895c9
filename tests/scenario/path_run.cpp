// See path_run.h.
#include "tests/scenario/path_run.h"

#include <algorithm>
#include <limits>

#include "core/math/rotation.h"
#include "core/rendering/recovery.h"

namespace hapticd::test {
namespace {

/// What is nearer than this beyond the motion of a tick is looked at, m.
constexpr double kAround = 1e-3;

/// Distance of `p` from a segment, m; straight from the definition.
double distance_to(const Vector3& p, const Capsule& capsule) {
  const Vector3 axis = capsule.p_B - capsule.p_A;
  const double square = axis.squaredNorm();
  const double lambda =
      square > 0.0 ? std::clamp((p - capsule.p_A).dot(axis) / square, 0.0, 1.0) : 0.0;
  return (p - capsule.p_A - lambda * axis).norm();
}

const StringHold* find_hold_of(const OptimiserState& state, std::size_t capsule) {
  for (const StringHold& hold : state.holds) {
    if (hold.yields && static_cast<std::size_t>(hold.bend.capsule) == capsule) return &hold;
  }
  return nullptr;
}

/// Upper bound of how far any point of tool and strings moves from `a` to `b`, m.
double motion(const OptimiserState& a, const OptimiserState& b, double reach,
              std::span<const Capsule> capsules) {
  const Vector3 phi = log_rotation(b.X_WG.q * a.X_WG.q.conjugate());
  double bound = (b.X_WG.p - a.X_WG.p).norm() + phi.norm() * reach;
  for (std::size_t i = 0; i < capsules.size(); ++i) {
    const StringHold* before = find_hold_of(a, i);
    const StringHold* after = find_hold_of(b, i);
    const double length = (capsules[i].p_B - capsules[i].p_A).norm();
    if (before != nullptr) bound += before->bend.u_W.norm();
    if (after != nullptr) bound += after->bend.u_W.norm();
    if (before != nullptr && after != nullptr) {
      bound += length * std::abs(after->bend.lambda - before->bend.lambda);
    }
  }
  return bound + greatest_displacement(a.parts) + greatest_displacement(b.parts);
}

/// A string on its way from one state to the other; one that is not held is straight, so that its
/// vertex may stand anywhere on its axis.
OracleBentString bent_string(const Capsule& string, std::size_t index, const OptimiserState& from,
                             const OptimiserState& to) {
  const StringHold* a = find_hold_of(from, index);
  const StringHold* b = find_hold_of(to, index);
  const double lambda_a = a != nullptr ? a->bend.lambda : b != nullptr ? b->bend.lambda : 0.5;
  const double lambda_b = b != nullptr ? b->bend.lambda : lambda_a;
  const Vector3 axis = string.p_B - string.p_A;
  OracleBentString bent{string, string.p_A + lambda_a * axis, string.p_A + lambda_b * axis};
  if (a != nullptr) bent.p_WP_from += a->bend.u_W;
  if (b != nullptr) bent.p_WP_to += b->bend.u_W;
  return bent;
}

}  // namespace

PathRun::PathRun(const Scene& scene, std::size_t tool) : scene_(scene), tool_(tool) {
  const ToolScene view = scene.tool_scene(tool);
  state_.X_WG = scene.description().tools[tool].X_WG;
  for (std::size_t i = 0; i < view.tool.leaf_r.size(); ++i) {
    tool_spheres_.push_back(view.tool.leaf(static_cast<std::int32_t>(i)));
  }
  for (const BodyView& body : view.obstacles.bodies) {
    for (std::size_t i = 0; i < body.tree.leaf_r.size(); ++i) {
      const Sphere leaf = body.tree.leaf(static_cast<std::int32_t>(i));
      body_spheres_W_.push_back({transform(body.X_WB, leaf.p), leaf.r});
    }
  }
  // Not even the thinnest obstacle can hide from the smallest sphere of the tool.
  double thinnest = 1.0;
  for (const Capsule& capsule : view.obstacles.capsules_W) thinnest = std::min(thinnest, capsule.r);
  for (const Sphere& sphere : body_spheres_W_) thinnest = std::min(thinnest, sphere.r);
  double smallest = 1.0;
  for (const Sphere& sphere : tool_spheres_) smallest = std::min(smallest, sphere.r);
  spacing_ = (smallest + thinnest) / 4.0;
}

void PathRun::note_touched() {
  const SceneDescription& d = scene_.description();
  for (int k = 0; k < state_.active_count; ++k) {
    const ActivePair& pair = state_.active[static_cast<std::size_t>(k)];
    if (!(pair.multiplier > 0.0)) continue;
    const auto index = static_cast<std::size_t>(pair.key.obstacle);
    if (pair.key.kind != ObstacleKind::kCapsule) {
      touched_.insert(d.bodies[index].name);
      continue;
    }
    const CapsuleOwner& owner = scene_.capsule_owners()[index];
    const auto of = static_cast<std::size_t>(owner.index);
    touched_.insert(owner.is_string ? d.strings[of].name : d.lines[of].name);
  }
}

void PathRun::tick(const Pose& X_WH) {
  const ToolScene view = scene_.tool_scene(tool_);
  optimise_configuration(optimiser_input(view, X_WH, 1e-3), state_, *workspace_, result_);
  note_touched();
}

long double PathRun::judged_tick(const Pose& X_WH) {
  const ToolScene view = scene_.tool_scene(tool_);
  const OptimiserInput input = optimiser_input(view, X_WH, 1e-3);
  std::vector<OptimiserState> path{state_};
  start_tick(input, state_, *workspace_, result_);
  if (workspace_->contacts.minimum_gap < 0.0) {
    recover(input, state_, *workspace_, result_);
    path.push_back(state_);
    return judge(path);
  }
  for (bool more = true; more && result_.sub_steps < input.options.sub_steps;) {
    prepare_sub_step(input, state_, *workspace_, result_);
    path.push_back(state_);
    more = advance_sub_step(input, state_, *workspace_, result_);
    path.push_back(state_);
  }
  finish_tick(input, state_);
  note_touched();
  return judge(path);
}

std::vector<Sphere> PathRun::displaced_spheres(const OptimiserState& state) const {
  const ToolParts parts = scene_.tool_scene(tool_).parts;
  std::vector<Sphere> spheres = tool_spheres_;
  for (const SoftPart& soft : state.parts) {
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      if (parts.part_of(static_cast<TreeSphereId>(i)) == soft.part) spheres[i].p += soft.v_G;
    }
  }
  return spheres;
}

PathRun::Vicinity PathRun::vicinity(const std::vector<OptimiserState>& path) const {
  const ToolScene view = scene_.tool_scene(tool_);
  const std::span<const Capsule> capsules = view.obstacles.capsules_W;
  const double reach_G = reach(view.tool);
  double far = kAround;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    far += motion(path[i], path[i + 1], reach_G, capsules);
  }
  const Pose& X_WG = path.front().X_WG;
  Vicinity near;
  for (std::size_t i = 0; i < capsules.size(); ++i) {
    const auto holds = [&](const OptimiserState& s) { return find_hold_of(s, i) != nullptr; };
    if (std::any_of(path.begin(), path.end(), holds)) {
      near.held.push_back(i);
    } else if (distance_to(X_WG.p, capsules[i]) - capsules[i].r <= reach_G + far) {
      near.straight.push_back(capsules[i]);
    }
  }
  std::vector<Sphere> bodies;
  for (const Sphere& sphere : body_spheres_W_) {
    if ((sphere.p - X_WG.p).norm() - sphere.r <= reach_G + far) bodies.push_back(sphere);
  }
  std::vector<bool> body_kept(bodies.size(), false);
  const std::vector<Sphere> spheres = displaced_spheres(path.front());
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Sphere sphere_W{transform(X_WG, spheres[i].p), spheres[i].r};
    const auto meets = [&](const Capsule& capsule) {
      return distance_to(sphere_W.p, capsule) <= far + sphere_W.r + capsule.r;
    };
    bool meets_any = std::any_of(near.straight.begin(), near.straight.end(), meets);
    for (const std::size_t k : near.held) meets_any = meets_any || meets(capsules[k]);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const double limit = far + sphere_W.r + bodies[k].r;
      if ((sphere_W.p - bodies[k].p).squaredNorm() > limit * limit) continue;
      meets_any = body_kept[k] = true;
    }
    if (meets_any) near.tool.push_back(i);
  }
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (body_kept[k]) near.bodies.push_back(bodies[k]);
  }
  return near;
}

long double PathRun::judge(const std::vector<OptimiserState>& path) const {
  const Vicinity near = vicinity(path);
  if (near.tool.empty()) return 1.0L;
  const std::span<const Capsule> capsules = scene_.tool_scene(tool_).obstacles.capsules_W;
  const std::vector<OracleBody> bodies{{near.bodies, Pose{}}};
  const auto some = [&](const OptimiserState& state) {
    const std::vector<Sphere> all = displaced_spheres(state);
    std::vector<Sphere> chosen;
    chosen.reserve(near.tool.size());
    for (const std::size_t i : near.tool) chosen.push_back(all[i]);
    return chosen;
  };
  long double smallest = std::numeric_limits<long double>::infinity();
  for (std::size_t step = 0; step + 1 < path.size(); ++step) {
    const OptimiserState& from = path[step];
    const OptimiserState& to = path[step + 1];
    std::vector<OracleBentString> bent;
    bent.reserve(near.held.size());
    for (const std::size_t k : near.held) bent.push_back(bent_string(capsules[k], k, from, to));
    smallest = std::min(smallest, path_minimum_gap(some(from), some(to), from.X_WG, to.X_WG,
                                                   {near.straight, bodies, bent}, spacing_));
  }
  return smallest;
}

}  // namespace hapticd::test
