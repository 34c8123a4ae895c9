// See path_judge.h.
#include "tests/truth/path_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/math/rotation.h"

namespace hapticd {
namespace {

/// How much farther than a blended surface its spheres are that still count there, in widths of the
/// blend.
constexpr double kBlendReach = 2.0;

/// Distance of `p` from a segment, m; straight from the definition.
double distance_to(const Vector3& p, const Capsule& capsule) {
  const Vector3 axis = capsule.p_B - capsule.p_A;
  const double square = axis.squaredNorm();
  const double lambda =
      square > 0.0 ? std::clamp((p - capsule.p_A).dot(axis) / square, 0.0, 1.0) : 0.0;
  return (p - capsule.p_A - lambda * axis).norm();
}

const TouchedString* find_string_of(const ContactState& state, std::size_t capsule) {
  for (const TouchedString& hold : state.touched) {
    if (hold.yields && static_cast<std::size_t>(hold.bend.capsule) == capsule) return &hold;
  }
  return nullptr;
}

double part_motion(const ContactState& state) { return greatest_displacement(state.parts); }

/// Upper bound of how far any point of the tool moves from `a` to `b`, m.
double tool_motion(const ContactState& a, const ContactState& b, double reach) {
  const Vector3 phi = log_rotation(b.X_WG.q * a.X_WG.q.conjugate());
  return (b.X_WG.p - a.X_WG.p).norm() + phi.norm() * reach + part_motion(a) + part_motion(b);
}

/// Upper bound of how far any point of a held string is from its straight line, m.
double string_deflection(const ContactState& state) {
  double most = 0.0;
  for (const TouchedString& hold : state.touched) {
    if (hold.yields) most = std::max(most, hold.bend.u_W.norm());
  }
  return most;
}

/// A string on its way from one state to the other; one that is not held is straight, so that its
/// vertex may stand anywhere on its axis.
OracleBentString bent_string(const Capsule& string, std::size_t index, const ContactState& from,
                             const ContactState& to) {
  const TouchedString* a = find_string_of(from, index);
  const TouchedString* b = find_string_of(to, index);
  const double lambda_a = a != nullptr ? a->bend.lambda : b != nullptr ? b->bend.lambda : 0.5;
  const double lambda_b = b != nullptr ? b->bend.lambda : lambda_a;
  const Vector3 axis = string.p_B - string.p_A;
  OracleBentString bent{string, string.p_A + lambda_a * axis, string.p_A + lambda_b * axis};
  if (a != nullptr) bent.p_WP_from += a->bend.u_W;
  if (b != nullptr) bent.p_WP_to += b->bend.u_W;
  return bent;
}

/// The capsule, or its two legs where it is bent.
std::vector<Capsule> legs_of(const Capsule& string, std::size_t index, const ContactState& state) {
  const TouchedString* hold = find_string_of(state, index);
  if (hold == nullptr) return {string};
  const Vector3 p_WP = string.p_A + hold->bend.lambda * (string.p_B - string.p_A) + hold->bend.u_W;
  return {{string.p_A, p_WP, string.r}, {p_WP, string.p_B, string.r}};
}

}  // namespace

PathJudge::PathJudge(const ToolScene& scene)
    : capsules_(scene.obstacles.capsules_W), parts_(scene.parts) {
  double smallest = 1.0;
  for (std::size_t i = 0; i < scene.tool.leaf_r.size(); ++i) {
    const Sphere leaf = scene.tool.leaf(static_cast<std::int32_t>(i));
    tool_spheres_.push_back(leaf);
    smallest = std::min(smallest, leaf.r);
    rigid_reach_ = std::max(rigid_reach_, leaf.p.norm() + leaf.r);
  }
  tool_groups_ = group_spheres(tool_spheres_);
  double thinnest = 1.0;
  for (const BodyView& body : scene.obstacles.bodies) {
    std::vector<Sphere> spheres_W;
    for (std::size_t i = 0; i < body.tree.leaf_r.size(); ++i) {
      const Sphere leaf = body.tree.leaf(static_cast<std::int32_t>(i));
      spheres_W.push_back({transform(body.X_WB, leaf.p), leaf.r});
      thinnest = std::min(thinnest, leaf.r);
    }
    seen_.emplace_back(spheres_W.size(), 0);
    blends_.push_back(body.tree.blend.width);
    bodies_.push_back(std::make_unique<SphereGrid>(std::move(spheres_W)));
  }
  // Not even the thinnest obstacle can hide from the smallest sphere of the tool.
  for (const Capsule& capsule : capsules_) thinnest = std::min(thinnest, capsule.r);
  spacing_ = (smallest + thinnest) / 4.0;
}

double PathJudge::reach(const ContactState& state) const {
  return rigid_reach_ + part_motion(state);
}

PathJudge::Displaced PathJudge::displaced_spheres(const ContactState& state) const {
  std::vector<Sphere> spheres = tool_spheres_;
  if (state.parts.empty()) return {std::move(spheres), tool_groups_};
  for (const SoftPart& soft : state.parts) {
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      if (parts_.part_of(static_cast<TreeSphereId>(i)) == soft.part) spheres[i].p += soft.v_G;
    }
  }
  std::vector<SphereGroup> groups = group_spheres(spheres);
  return {std::move(spheres), std::move(groups)};
}

bool PathJudge::meets_nothing(const Vicinity& near, const Sphere& ball_W, double far,
                              double bent) const {
  const auto meets = [&](const Capsule& capsule, double beyond) {
    return distance_to(ball_W.p, capsule) <= far + beyond + ball_W.r + capsule.r;
  };
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const double beyond = far + kBlendReach * blends_[k] + ball_W.r;
    if (!bodies_[k]->nothing_near(ball_W.p, beyond)) return false;
  }
  return std::none_of(near.straight.begin(), near.straight.end(),
                      [&](const Capsule& capsule) { return meets(capsule, 0.0); }) &&
         std::none_of(near.held.begin(), near.held.end(),
                      [&](std::size_t k) { return meets(capsules_[k], bent); });
}

PathJudge::Vicinity PathJudge::vicinity(std::span<const ContactState> path) {
  double far = kFarthestGap;
  double bent = 0.0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    far += tool_motion(path[i], path[i + 1], reach(path[i]));
  }
  for (const ContactState& state : path) bent = std::max(bent, string_deflection(state));
  const Pose& X_WG = path.front().X_WG;
  Vicinity near;
  near.bodies.resize(bodies_.size());
  for (std::size_t i = 0; i < capsules_.size(); ++i) {
    const auto holds = [&](const ContactState& s) { return find_string_of(s, i) != nullptr; };
    if (std::any_of(path.begin(), path.end(), holds)) {
      near.held.push_back(i);
    } else if (distance_to(X_WG.p, capsules_[i]) - capsules_[i].r <= reach(path.front()) + far) {
      near.straight.push_back(capsules_[i]);
    }
  }
  ++looks_;
  const Displaced tool_G = displaced_spheres(path.front());
  const auto is_far = [&](const Sphere& ball_W) { return meets_nothing(near, ball_W, far, bent); };
  visit_spheres(tool_G.groups, X_WG, is_far, [&](std::size_t i) {
    const Sphere sphere_W{transform(X_WG, tool_G.spheres[i].p), tool_G.spheres[i].r};
    const auto meets = [&](const Capsule& capsule, double beyond) {
      return distance_to(sphere_W.p, capsule) <= far + beyond + sphere_W.r + capsule.r;
    };
    bool meets_any = std::any_of(near.straight.begin(), near.straight.end(),
                                 [&](const Capsule& capsule) { return meets(capsule, 0.0); });
    for (const std::size_t k : near.held) meets_any = meets_any || meets(capsules_[k], bent);
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      const std::vector<Sphere>& obstacles = bodies_[body]->spheres();
      const double beyond = far + kBlendReach * blends_[body] + sphere_W.r;
      bodies_[body]->visit_near(sphere_W.p, beyond, [&](std::size_t k) {
        const double limit = beyond + obstacles[k].r;
        if ((sphere_W.p - obstacles[k].p).squaredNorm() > limit * limit) return;
        meets_any = true;
        if (std::exchange(seen_[body][k], looks_) == looks_) return;
        near.bodies[body].push_back(obstacles[k]);
      });
    }
    if (meets_any) near.tool.push_back(i);
  });
  return near;
}

double PathJudge::smallest_gap(std::span<const ContactState> path) {
  const Vicinity near = vicinity(path);
  if (near.tool.empty()) return kFarthestGap;
  std::vector<OracleBody> bodies;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (!near.bodies[k].empty()) bodies.push_back({near.bodies[k], Pose{}, blends_[k]});
  }
  const auto some = [&](const ContactState& state) {
    const std::vector<Sphere> all = displaced_spheres(state).spheres;
    std::vector<Sphere> chosen;
    chosen.reserve(near.tool.size());
    for (const std::size_t i : near.tool) chosen.push_back(all[i]);
    return chosen;
  };
  long double smallest = kFarthestGap;
  for (std::size_t step = 0; step + 1 < path.size(); ++step) {
    const ContactState& from = path[step];
    const ContactState& to = path[step + 1];
    std::vector<OracleBentString> bent;
    bent.reserve(near.held.size());
    for (const std::size_t k : near.held) bent.push_back(bent_string(capsules_[k], k, from, to));
    const std::vector<Sphere> first = some(from);
    const std::vector<Sphere> last = some(to);
    smallest = std::min(smallest, path_minimum_gap({first, from.X_WG}, {last, to.X_WG},
                                                   {near.straight, bodies, bent}, spacing_));
  }
  return static_cast<double>(smallest);
}

double PathJudge::gap_to_capsule(std::span<const Capsule> legs, const Displaced& tool_G,
                                 const Pose& X_WG) const {
  long double smallest = kFarthestGap;
  std::vector<Sphere> near;
  const auto is_far = [&](const Sphere& ball_W) {
    return std::none_of(legs.begin(), legs.end(), [&](const Capsule& leg) {
      return distance_to(ball_W.p, leg) <= 2.0 * kFarthestGap + ball_W.r + leg.r;
    });
  };
  visit_spheres(tool_G.groups, X_WG, is_far, [&](std::size_t i) {
    const Sphere& sphere = tool_G.spheres[i];
    if (!is_far({transform(X_WG, sphere.p), sphere.r})) near.push_back(sphere);
  });
  if (!near.empty()) smallest = std::min(smallest, exhaustive_minimum_gap(near, X_WG, {legs, {}}));
  return static_cast<double>(smallest);
}

double PathJudge::gap_to_body(std::size_t body, const Displaced& tool_G, const Pose& X_WG) const {
  const SphereGrid& grid = *bodies_[body];
  const double beyond = 2.0 * kFarthestGap + kBlendReach * blends_[body];
  std::vector<Sphere> near_tool;
  std::vector<std::size_t> near_body;
  const auto is_far = [&](const Sphere& ball_W) {
    return grid.nothing_near(ball_W.p, ball_W.r + beyond);
  };
  visit_spheres(tool_G.groups, X_WG, is_far, [&](std::size_t i) {
    const Sphere& sphere = tool_G.spheres[i];
    const Vector3 p_W = transform(X_WG, sphere.p);
    const std::size_t before = near_body.size();
    grid.visit_near(p_W, sphere.r + beyond, [&](std::size_t k) {
      const double limit = beyond + sphere.r + grid.spheres()[k].r;
      if ((p_W - grid.spheres()[k].p).squaredNorm() <= limit * limit) near_body.push_back(k);
    });
    if (near_body.size() > before) near_tool.push_back(sphere);
  });
  if (near_tool.empty()) return kFarthestGap;
  std::sort(near_body.begin(), near_body.end());
  near_body.erase(std::unique(near_body.begin(), near_body.end()), near_body.end());
  std::vector<Sphere> spheres;
  spheres.reserve(near_body.size());
  for (const std::size_t k : near_body) spheres.push_back(grid.spheres()[k]);
  const std::array<OracleBody, 1> bodies{{{spheres, Pose{}, blends_[body]}}};
  const long double gap = exhaustive_minimum_gap(near_tool, X_WG, {{}, bodies});
  return static_cast<double>(std::min<long double>(gap, kFarthestGap));
}

ObstacleGaps PathJudge::gaps(const ContactState& state) {
  const Displaced tool_G = displaced_spheres(state);
  const double near = reach(state) + kFarthestGap;
  ObstacleGaps gaps;
  for (std::size_t i = 0; i < capsules_.size(); ++i) {
    const bool held = find_string_of(state, i) != nullptr;
    const bool far = !held && distance_to(state.X_WG.p, capsules_[i]) - capsules_[i].r > near;
    gaps.capsules.push_back(
        far ? kFarthestGap : gap_to_capsule(legs_of(capsules_[i], i, state), tool_G, state.X_WG));
  }
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    gaps.bodies.push_back(gap_to_body(body, tool_G, state.X_WG));
  }
  return gaps;
}

}  // namespace hapticd
