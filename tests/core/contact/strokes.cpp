// Random tools, obstacles and paths of the strokes. See strokes.h.
#include "tests/core/contact/strokes.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation.h"

namespace hapticd::test {
namespace {

double log_uniform(SplitMix64& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

Vector3 random_direction(SplitMix64& random) { return to_vector(random.direction()); }

/// A single sphere at a lever arm, a finger of spheres in a row, or a cluster. The first sphere is
/// the one that is aimed.
std::vector<Sphere> make_tool(SplitMix64& random) {
  const double r = log_uniform(random, 0.1e-3, 10e-3);
  const Vector3 tip = random_direction(random) * log_uniform(random, 1e-3, 0.1);
  switch (random.below(4)) {
    case 0:
      return {{Vector3::Zero(), r}};
    case 1:
      return {{tip, r}};
    case 2: {
      std::vector<Sphere> finger;
      const auto count = 7 + random.below(8);
      finger.reserve(count);
      for (std::uint64_t i = 0; i < count; ++i) {
        finger.push_back({tip * (1.0 - static_cast<double>(i) / static_cast<double>(count)), r});
      }
      return finger;
    }
    default: {
      std::vector<Sphere> cluster{{tip, r}};
      for (int i = 0; i < 12; ++i) {
        cluster.push_back({tip + random_direction(random) * random.uniform(0.0, 0.03),
                           log_uniform(random, 0.1e-3, 10e-3)});
      }
      return cluster;
    }
  }
}

void add_obstacles(SplitMix64& random, RenderingScene& scene) {
  scene.capsules_W.push_back({{-0.55, 0, 0}, {0.55, 0, 0}, kStringRadius});
  if (random.chance(0.3))
    scene.capsules_W.push_back({{-0.55, 0, 0.02}, {0.55, 0, 0.015}, kStringRadius});
  if (random.chance(0.2)) {
    std::vector<Sphere> plate;
    plate.reserve(24);
    for (int i = 0; i < 24; ++i) {
      plate.push_back({{0.004 * (i % 6), 0, 0.004 * static_cast<int>(i / 6)}, 5e-3});
    }
    scene.add_body(plate,
                   {exp_rotation(random_direction(random) * random.uniform(0.0, 3.0)),
                    Vector3(random.uniform(-0.02, 0.02), -0.02, random.uniform(-0.02, 0.02))});
  }
}

/// Where the aimed sphere starts and ends, relative to the string through the origin along x.
struct Aim {
  Vector3 from, to;
};

Aim make_aim(SplitMix64& random, StrokeKind kind, double r) {
  const double s = r + kStringRadius;
  const double side = random.chance(0.5) ? 1.0 : -1.0;
  const double offset = random.uniform(-1.0, 1.0) * s;
  const double away = side * (s + random.uniform(0.5e-3, 0.03));
  const double beyond = -side * random.uniform(0.0, 0.03);
  switch (kind) {
    case StrokeKind::kAxial: {
      const double x = random.uniform(-0.5, 0.5);
      const double depth = side * random.uniform(-0.5, 0.9) * s;
      return {{x, away, offset}, {x + random.uniform(-0.3, 0.3), depth, offset}};
    }
    case StrokeKind::kEndCap: {
      const double end = random.chance(0.5) ? 0.55 : -0.55;
      const Vector3 aim(end, random.uniform(-1.0, 1.0) * s, offset);
      const Vector3 from = aim + Vector3(end > 0 ? 1.0 : -1.0, random.uniform(-1.0, 1.0), 0.0) *
                                     (s + std::abs(away));
      return {from, aim - (from - aim) * random.uniform(0.0, 1.5)};
    }
    case StrokeKind::kOblique: {
      const double x = random.uniform(-0.5, 0.5);
      return {{x, away, offset},
              {x + random.uniform(-0.1, 0.1), beyond, offset + random.uniform(-0.03, 0.03)}};
    }
    case StrokeKind::kTeleport: {
      const Vector3 from(random.uniform(-0.5, 0.5), away, offset);
      const Vector3 aim(random.uniform(-0.5, 0.5), 0.0, random.uniform(-1.0, 1.0) * s);
      return {from, from + (aim - from).normalized() * log_uniform(random, 0.1, 10.0)};
    }
    default: {
      const double x = random.uniform(-0.5, 0.5);
      return {{x, away, offset}, {x, beyond, offset}};
    }
  }
}

/// Poses of the tool's origin that carry the aimed sphere from `aim.from` to `aim.to` at `speed`.
std::vector<Pose> make_poses(SplitMix64& random, StrokeKind kind, const Aim& aim,
                             const Vector3& tip, double speed) {
  const Quaternion q_start = exp_rotation(random_direction(random) * random.uniform(0.0, 3.1));
  const Vector3 p_from = aim.from - q_start * tip;
  const double way = (aim.to - aim.from).norm();
  const bool turns = kind == StrokeKind::kRotation || kind == StrokeKind::kScrew ||
                     (kind == StrokeKind::kTeleport && random.chance(0.5));
  const bool translates = kind != StrokeKind::kRotation;
  // Rotation that sweeps the aimed sphere towards its target; a sphere at the origin turns in
  // place.
  const Vector3 arm = q_start * tip;
  Vector3 axis = arm.cross(aim.to - aim.from);
  if (!(axis.norm() > 1e-9)) axis = random_direction(random);
  axis.normalize();
  const double angle = turns ? std::min(way / std::max(arm.norm(), 5e-3), 3.0) : 0.0;
  const int ticks = kind == StrokeKind::kTeleport
                        ? 1
                        : std::max(1, static_cast<int>(std::ceil(way / (speed * 1e-3))));
  const double hold = random.chance(0.5) ? 1.0 : 0.0;

  std::vector<Pose> poses;
  for (int i = 0; i <= ticks; ++i) {
    const double s = static_cast<double>(i) / ticks;
    const Vector3 p = translates ? Vector3(p_from + s * (aim.to - aim.from)) : p_from;
    poses.push_back({renormalised(exp_rotation(axis * (s * angle)) * q_start), p});
  }
  for (int i = 0; i < 3 + static_cast<int>(hold) * 5; ++i) poses.push_back(poses.back());
  // And back again, so that both sides of the obstacle are left as well as met.
  if (random.chance(0.3)) poses.insert(poses.end(), poses.rbegin(), poses.rend());
  return poses;
}

StringParameters random_string(SplitMix64& random, const Capsule& capsule) {
  StringParameters string;
  string.p_WA = to_array(capsule.p_A);
  string.p_WB = to_array(capsule.p_B);
  string.radius = capsule.r;
  string.tension = random.chance(0.1) ? 0.0 : log_uniform(random, 0.1, 300.0);
  string.youngs_modulus = random.chance(0.1) ? 0.0 : log_uniform(random, 1e6, 1e12);
  string.contact_stiffness = log_uniform(random, 100.0, 5000.0);
  string.friction_coefficient = random.uniform(0.0, 1.0);
  string.model = random.chance(0.9) ? StringContact::kYielding : StringContact::kStraight;
  return string;
}

}  // namespace

Stroke make_string_stroke(std::uint64_t seed) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    SplitMix64 random((seed << 8U) + attempt);
    Stroke stroke = make_stroke(random.next() >> 20U);
    RenderingScene& scene = stroke.scene;
    if (scene.capsules_W.size() < 2 && random.chance(0.5)) {
      const double away = random.uniform(-0.02, 0.02);
      scene.capsules_W.push_back({{-0.55, away, 0.01}, {0.55, away, 0.015}, kStringRadius});
    }
    if (random.chance(0.4)) {
      scene.capsules_W.push_back({{-0.55, 0.0, -0.012}, {0.55, 0.0, -0.008}, kStringRadius});
    }
    for (const Capsule& capsule : scene.capsules_W) {
      scene.strings.push_back(derive_string(random_string(random, capsule)));
    }
    scene.instrument.friction = random.chance(0.4);
    scene.instrument.anchor_stiffness = log_uniform(random, 100.0, 1e4);
    scene.instrument.lateral_force = random.chance(0.3);
    if (scene.true_gap(stroke.X_WH.front()) > 1e-4L) return stroke;
  }
}

std::string Stroke::describe() const {
  static constexpr const char* kNames[] = {"across",   "oblique", "axial",   "end cap",
                                           "rotation", "screw",   "teleport"};
  return std::string(kNames[static_cast<std::size_t>(kind)]) + " at " + std::to_string(speed) +
         " m/s, " + std::to_string(scene.tool_spheres.size()) + " spheres, first r " +
         std::to_string(scene.tool_spheres.front().r);
}

Stroke make_stroke(std::uint64_t seed) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    SplitMix64 random(seed * 1000 + attempt);
    const auto kind = static_cast<StrokeKind>(random.below(kStrokeKinds));
    const double speed = log_uniform(random, 0.1, 100.0);
    const std::vector<Sphere> tool = make_tool(random);
    Stroke stroke{kind, speed, RenderingScene(tool), {}};
    add_obstacles(random, stroke.scene);
    stroke.X_WH =
        make_poses(random, kind, make_aim(random, kind, tool.front().r), tool.front().p, speed);
    if (stroke.scene.true_gap(stroke.X_WH.front()) > 1e-4L) return stroke;
  }
}

}  // namespace hapticd::test
