// See closed_path.h.
#include "tests/scenario/closed_path.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation.h"

namespace hapticd::test {
namespace {

constexpr double kTwoPi = 6.283185307179586;
/// How far the hand is lifted off the surface, m.
constexpr double kLift = 1e-3;
/// Of the fastest place of a lap, m and rad per tick.
constexpr double kStep = 40e-6;
constexpr double kTurn = 1e-3;

/// Where a leaf of the tool comes down, and what of the obstacle it then moves along.
struct Place {
  Vector3 p_W;    ///< on the surface
  Vector3 out;    ///< unit normal
  Vector3 along;  ///< unit, along a string or line; else any tangent
  double reach;   ///< how far the hand may go along it, m
};

Vector3 tangent(const Vector3& normal, SplitMix64& random) {
  for (;;) {
    const Vector3 v = to_vector(random.direction());
    const Vector3 across = v - normal.dot(v) * normal;
    if (across.norm() > 0.1) return across.normalized();
  }
}

Place random_place(const ToolScene& view, const Vector3& p_above, SplitMix64& random) {
  const auto capsules = view.obstacles.capsules_W;
  const auto bodies = view.obstacles.bodies;
  // Strings first: they are what stores most.
  const bool on_capsule = !capsules.empty() && (bodies.empty() || random.chance(0.7));
  if (on_capsule) {
    const bool string = !view.strings.empty() && random.chance(0.9);
    const Capsule& line = capsules[random.below(string ? view.strings.size() : capsules.size())];
    const Vector3 axis = (line.p_B - line.p_A).normalized();
    const double length = (line.p_B - line.p_A).norm();
    const double lambda = random.uniform(0.04, 0.96);
    const Vector3 p = line.p_A + lambda * (line.p_B - line.p_A);
    Vector3 out = p_above - p;
    out -= axis.dot(out) * axis;
    if (!(out.norm() > 1e-3)) out = axis.unitOrthogonal();
    const double reach = length * (std::min(lambda, 1.0 - lambda) - 0.03);
    return {p + line.r * out.normalized(), out.normalized(), axis, std::max(reach, 1e-3)};
  }
  const BodyView& body = bodies[random.below(bodies.size())];
  const Sphere leaf =
      body.tree.leaf(static_cast<std::int32_t>(random.below(body.tree.leaf_r.size())));
  const Vector3 p = transform(body.X_WB, leaf.p);
  const Vector3 out = (leaf.r > 1.0 ? Vector3(0.0, 0.0, 1.0) : (p_above - p).normalized());
  return {p + leaf.r * out, out, tangent(out, random), 5e-3};
}

/// The leaf that reaches furthest along `way_G`.
Sphere foremost_leaf(const SphereTreeView& tool, const Vector3& way_G) {
  Sphere foremost = tool.leaf(0);
  double furthest = -1e9;
  for (std::size_t k = 0; k < tool.leaf_r.size(); ++k) {
    const Sphere leaf = tool.leaf(static_cast<std::int32_t>(k));
    const double reach = way_G.dot(leaf.p) + way_G.norm() * leaf.r;
    if (reach > furthest) {
      furthest = reach;
      foremost = leaf;
    }
  }
  return foremost;
}

}  // namespace

Pose ClosedPath::at(double share) const {
  const double s = kTwoPi * share;
  const double first = std::sin(s);
  const double second = std::sin(2.0 * s + 1.0) - std::sin(1.0);
  const Vector3 p =
      X_WH.p + 0.5 * (1.0 - std::cos(s)) * down + first * aside[0] + second * aside[1];
  return {renormalised(exp_rotation(first * turn[0] + second * turn[1]) * X_WH.q), p};
}

ClosedPath random_lap(const ToolScene& view, const Pose& X_WH, SplitMix64& random) {
  const Place place = random_place(view, X_WH.p + Vector3(0.0, 0.5, 0.0), random);
  const Sphere leaf = foremost_leaf(
      view.tool, X_WH.q.conjugate() * (-place.out + 0.5 * to_vector(random.direction())));
  ClosedPath path;
  path.X_WH = {X_WH.q, place.p_W + (leaf.r + kLift) * place.out - X_WH.q * leaf.p};
  const double depth = random.uniform(0.5e-3, 4e-3);
  path.down = -(kLift + depth) * place.out;
  const Vector3 across = place.out.cross(place.along);
  const double reach = std::min(place.reach, 1e-3 * std::pow(200.0, random.uniform()));
  double turned = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    path.aside[k] =
        random.uniform(-0.4, 0.4) * reach * place.along + random.uniform(-0.3e-3, 0.3e-3) * across;
    path.turn[k] = random.uniform(0.0, 0.05) * to_vector(random.direction());
    turned += static_cast<double>(k + 1) * path.turn[k].norm();
  }
  const double speed = 0.5 * path.down.norm() + path.aside[0].norm() + 2.0 * path.aside[1].norm();
  const double ticks = kTwoPi * std::max(speed / kStep, turned / kTurn);
  path.ticks = static_cast<int>(std::clamp(ticks, 400.0, 8000.0));
  return path;
}

}  // namespace hapticd::test
