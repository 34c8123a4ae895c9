// See rest_places.h.
#include "core/scene/rest_places.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/collision/blended_surface.h"
#include "core/math/rotation.h"

namespace hapticd {
namespace {

/// A line whose direction has a smaller part across the string runs along it.
constexpr double kCrossing = 0.2;
/// Share of the length next to an end in which a string lies on nothing but its end.
constexpr double kEndShare = 1e-3;
/// Where leaves blend, their surface is looked for to this, m, in so many steps, each as long as it
/// is certainly far.
constexpr double kBlendTolerance = 1e-6;
constexpr int kBlendSteps = 64;
/// Nearer than this the direction from one axis to the other is not known, m.
constexpr double kLeastDistance = 1e-9;

/// A straight string.
struct Axis {
  Vector3 p_A;
  Vector3 along;  ///< unit
  double length;
  double radius;

  [[nodiscard]] Vector3 at(double lambda) const { return p_A + lambda * length * along; }
  [[nodiscard]] Vector3 across(const Vector3& v) const { return v - v.dot(along) * along; }
};

Axis axis_of(const StringDescription& string) {
  const Vector3 p_A = to_vector(string.parameters.p_WA);
  const Vector3 way = to_vector(string.parameters.p_WB) - p_A;
  const double length = way.norm();
  return {p_A, way / length, length, string.parameters.radius};
}

/// Places along a string at which a surface is looked at.
std::vector<double> sampled(const Axis& axis) {
  const double pitch = std::max(axis.length / (kMaxBodyRests + 1), kMinRestPitch);
  const int count = std::min(kMaxBodyRests, static_cast<int>(axis.length / pitch) - 1);
  std::vector<double> places;
  for (int k = 1; k <= count; ++k) places.push_back(static_cast<double>(k) / (count + 1));
  return places;
}

/// Adds `rest`, `gap` below the string along -nhat_W.
void add(const Axis& axis, double gap, StringRest rest, RestPlaces& places) {
  places.nearest_gap = std::min(places.nearest_gap, gap);
  // What it lies in a little it touches.
  rest.p_W = axis.at(rest.lambda) - std::max(gap, 0.0) * rest.nhat_W;
  places.rests.push_back(rest);
}

/// Places of string and line where these are nearest.
struct Nearest {
  double lambda;
  Vector3 p_WL;
  bool surface = false;
};

/// Of the string and a leg that crosses it.
Nearest nearest_places(const Axis& axis, const Vector3& p, const Vector3& q) {
  const Vector3 leg = q - p;
  const Vector3 leg_across = axis.across(leg);
  const double share =
      std::clamp(-axis.across(p - axis.p_A).dot(leg_across) / leg_across.squaredNorm(), 0.0, 1.0);
  const Vector3 p_WL = p + share * leg;
  return {(p_WL - axis.p_A).dot(axis.along) / axis.length, p_WL};
}

bool is_within(double lambda) { return lambda > kEndShare && lambda < 1.0 - kEndShare; }

void add_crossing(const Axis& axis, const Nearest& nearest, double radius, RestPlaces& places) {
  if (!is_within(nearest.lambda)) return;
  const Vector3 apart = axis.across(axis.at(nearest.lambda) - nearest.p_WL);
  const double distance = apart.norm();
  if (distance < kLeastDistance) {
    places.nearest_gap = std::min(places.nearest_gap, -radius - axis.radius);
    return;
  }
  const double gap = distance - radius - axis.radius;
  if (gap >= kRestReach) return;
  StringRest rest;
  rest.p_W = nearest.p_WL;
  rest.lambda = nearest.lambda;
  rest.nhat_W = apart / distance;
  rest.surface = nearest.surface;
  add(axis, gap, rest, places);
}

/// A leg that runs along the string, by its sections across it.
void add_along(const Axis& axis, const Vector3& p, const Vector3& q, double radius,
               RestPlaces& places) {
  const double from = (p - axis.p_A).dot(axis.along) / axis.length;
  const double to = (q - axis.p_A).dot(axis.along) / axis.length;
  for (const double lambda : sampled(axis)) {
    const double share = (lambda - from) / (to - from);
    if (!(share >= 0.0 && share <= 1.0)) continue;
    add_crossing(axis, {lambda, p + share * (q - p), true}, radius, places);
  }
}

void sort(RestPlaces& places) {
  std::sort(places.rests.begin(), places.rests.end(),
            [](const StringRest& a, const StringRest& b) { return a.lambda < b.lambda; });
}

/// Leaves of a body that come within reach of a string, in W.
std::vector<Sphere> leaves_near(const Axis& axis, const BodyDescription& body) {
  const SphereTreeView tree = body.shape.tree->tree.view();
  const Matrix3 R_WB = rotation_matrix(body.X_WB.q);
  std::vector<Sphere> near;
  for (std::size_t i = 0; i < tree.leaf_r.size(); ++i) {
    const Sphere leaf = tree.leaf(static_cast<std::int32_t>(i));
    const Vector3 p_W = rotate(R_WB, leaf.p) + body.X_WB.p;
    const double along = (p_W - axis.p_A).dot(axis.along);
    const double room = kRestReach + leaf.r + axis.radius;
    if (along < -leaf.r || along > axis.length + leaf.r) continue;
    if (axis.across(p_W - axis.p_A).norm() <= room) near.push_back({p_W, leaf.r});
  }
  return near;
}

/// From the body to the string: away from what is nearest, all along.
std::optional<Vector3> side_of(const Axis& axis, const std::vector<Sphere>& near) {
  Vector3 sum = Vector3::Zero();
  for (const Sphere& leaf : near) {
    const Vector3 apart = -axis.across(leaf.p - axis.p_A);
    const double distance = apart.norm();
    if (distance < kLeastDistance) continue;
    const double gap = std::max(distance - leaf.r, kMinRestPitch);
    sum += apart / distance / (gap * gap);
  }
  const double length = sum.norm();
  if (!(length > 0.0)) return std::nullopt;
  return sum / length;
}

/// How far below p along -n the leaves begin, m; kRestReach where there is none.
double depth_below(const Vector3& p, const Vector3& n, const std::vector<Sphere>& near) {
  double least = kRestReach;
  for (const Sphere& leaf : near) {
    const Vector3 to = leaf.p - p;
    const double down = -to.dot(n);
    const double aside = to.squaredNorm() - down * down;
    if (aside >= leaf.r * leaf.r) continue;
    least = std::min(least, down - std::sqrt(leaf.r * leaf.r - aside));
  }
  return least;
}

/// Gap of a string at p along -n to the surface that the leaves of a body blend into, m: higher
/// than theirs.
double gap_to_blended(const Axis& axis, const Vector3& p_W, const Vector3& n,
                      const BodyDescription& body) {
  const SphereTreeView tree = body.shape.tree->tree.view();
  const Matrix3 R_BW = rotation_matrix(body.X_WB.q).transpose();
  double gap = 0.0;
  for (int step = 0; step < kBlendSteps; ++step) {
    const Vector3 p_B = R_BW * (p_W - gap * n - body.X_WB.p);
    const double distance = place_beside_blend(tree, p_B).distance - axis.radius;
    gap += distance;
    if (std::abs(distance) <= kBlendTolerance) break;
  }
  return gap;
}

}  // namespace

RestPlaces places_on_line(const SceneDescription& scene, std::size_t string, std::size_t line) {
  const Axis axis = axis_of(scene.strings[string]);
  const LineDescription& thing = scene.lines[line];
  RestPlaces places;
  for (std::size_t k = 0; k + 1 < thing.points_W.size(); ++k) {
    const Vector3& p = thing.points_W[k];
    const Vector3& q = thing.points_W[k + 1];
    const double length = (q - p).norm();
    if (axis.across(q - p).norm() > kCrossing * length || !(length > 0.0)) {
      add_crossing(axis, nearest_places(axis, p, q), thing.radius, places);
    } else {
      add_along(axis, p, q, thing.radius, places);
    }
  }
  for (StringRest& rest : places.rests) rest.friction = thing.friction_coefficient;
  sort(places);
  return places;
}

RestPlaces places_on_body(const SceneDescription& scene, std::size_t string, std::size_t body) {
  const Axis axis = axis_of(scene.strings[string]);
  const BodyDescription& thing = scene.bodies[body];
  RestPlaces places;
  const std::vector<Sphere> near = leaves_near(axis, thing);
  const std::optional<Vector3> n = side_of(axis, near);
  if (!n) return places;
  for (const double lambda : sampled(axis)) {
    double gap = depth_below(axis.at(lambda), *n, near) - axis.radius;
    if (gap >= kRestReach - axis.radius) continue;
    if (thing.shape.tree->tree.blend.width > 0.0) {
      gap = gap_to_blended(axis, axis.at(lambda), *n, thing);
    }
    StringRest rest;
    rest.p_W = axis.at(lambda);
    rest.lambda = lambda;
    rest.nhat_W = *n;
    rest.surface = true;
    add(axis, gap, rest, places);
  }
  for (StringRest& rest : places.rests) rest.friction = thing.friction_coefficient;
  return places;
}

std::vector<StringRest> all_rests(const SceneDescription& scene,
                                  const std::vector<std::int32_t>& pieces) {
  std::vector<StringRest> all;
  for (std::size_t i = 0; i < scene.strings.size(); ++i) {
    RestPlaces places;
    const auto take = [&](const RestPlaces& of) {
      places.rests.insert(places.rests.end(), of.rests.begin(), of.rests.end());
    };
    for (const std::size_t line : scene.strings[i].touched_lines) {
      take(places_on_line(scene, i, line));
    }
    for (const std::size_t body : scene.strings[i].touched_bodies) {
      take(places_on_body(scene, i, body));
    }
    sort(places);
    for (StringRest& rest : places.rests) {
      rest.string = pieces[i];
      all.push_back(rest);
    }
  }
  return all;
}

}  // namespace hapticd
