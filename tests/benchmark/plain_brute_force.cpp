// See plain_brute_force.h.
#include "tests/benchmark/plain_brute_force.h"
#include "tests/support/pose_composition.h"

#include <algorithm>
#include <cmath>

namespace hapticd::test {
namespace {

/// gap[i] of every leaf of `tree` to the sphere at p with radius r.
[[gnu::noinline]] void gaps_to_sphere(const SphereTreeView& tree, const Vector3& p, double r,
                                      double* gap) {
  const std::size_t count = tree.leaf_x.size();
  const double* x = tree.leaf_x.data();
  const double* y = tree.leaf_y.data();
  const double* z = tree.leaf_z.data();
  const double* radius = tree.leaf_r.data();
  const double px = p.x();
  const double py = p.y();
  const double pz = p.z();
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = x[i] - px;
    const double dy = y[i] - py;
    const double dz = z[i] - pz;
    gap[i] = std::sqrt(dx * dx + dy * dy + dz * dz) - r - radius[i];
  }
}

/// gap[i] of every leaf of `tree` to the capsule from a along e with radius r.
[[gnu::noinline]] void gaps_to_capsule(const SphereTreeView& tree, const Vector3& a,
                                       const Vector3& e, double r, double* gap) {
  const std::size_t count = tree.leaf_x.size();
  const double* x = tree.leaf_x.data();
  const double* y = tree.leaf_y.data();
  const double* z = tree.leaf_z.data();
  const double* radius = tree.leaf_r.data();
  const double ax = a.x();
  const double ay = a.y();
  const double az = a.z();
  const double ex = e.x();
  const double ey = e.y();
  const double ez = e.z();
  const double inverse = 1.0 / e.squaredNorm();
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = x[i] - ax;
    const double dy = y[i] - ay;
    const double dz = z[i] - az;
    double s = (dx * ex + dy * ey + dz * ez) * inverse;
    s = s > 0.0 ? s : 0.0;
    s = s < 1.0 ? s : 1.0;
    const double ox = dx - s * ex;
    const double oy = dy - s * ey;
    const double oz = dz - s * ez;
    gap[i] = std::sqrt(ox * ox + oy * oy + oz * oz) - r - radius[i];
  }
}

}  // namespace

void PlainBruteForce::take(const ContactKey& key, const Pose& X_WG, const ObstaclesView& obstacles,
                           ContactSet& out) {
  const Contact contact = evaluate_contact(key, {tool_, X_WG}, obstacles);
  out.minimum_gap = std::min(out.minimum_gap, contact.gap);
  if (contact.gap < out.covered_margin) out.contacts.push_back(contact);
}

void PlainBruteForce::against_capsule(const Pose& X_WG, const ObstaclesView& obstacles,
                                      std::int32_t capsule, ContactSet& out) {
  const Capsule& capsule_W = obstacles.capsules_W[static_cast<std::size_t>(capsule)];
  const Pose X_GW = inverse(X_WG);
  const Vector3 a = transform(X_GW, capsule_W.p_A);
  gaps_to_capsule(tool_, a, transform(X_GW, capsule_W.p_B) - a, capsule_W.r, gap_.data());
  for (std::size_t i = 0; i < tool_.leaf_x.size(); ++i) {
    if (gap_[i] < std::max(out.covered_margin, out.minimum_gap)) {
      take({ObstacleKind::kCapsule, capsule, static_cast<TreeSphereId>(i), 0}, X_WG, obstacles,
           out);
    }
  }
}

void PlainBruteForce::against_body(const Pose& X_WG, const ObstaclesView& obstacles,
                                   std::int32_t body, ContactSet& out) {
  const BodyView& body_W = obstacles.bodies[static_cast<std::size_t>(body)];
  const Pose X_BG = compose(inverse(body_W.X_WB), X_WG);
  for (std::size_t i = 0; i < tool_.leaf_x.size(); ++i) {
    const auto tool_sphere = static_cast<TreeSphereId>(i);
    const Sphere sphere = tool_.leaf(tool_sphere);
    gaps_to_sphere(body_W.tree, transform(X_BG, sphere.p), sphere.r, gap_.data());
    for (std::size_t j = 0; j < body_W.tree.leaf_x.size(); ++j) {
      if (gap_[j] < std::max(out.covered_margin, out.minimum_gap)) {
        take({ObstacleKind::kBody, body, tool_sphere, static_cast<TreeSphereId>(j)}, X_WG,
             obstacles, out);
      }
    }
  }
}

void PlainBruteForce::find(const Pose& X_WG, const ObstaclesView& obstacles,
                           const QueryOptions& options, ContactSet& out) {
  out.contacts.clear();
  out.minimum_gap = options.horizon;
  out.covered_margin = options.margin;
  std::size_t longest = tool_.leaf_x.size();
  for (const BodyView& body : obstacles.bodies) {
    longest = std::max(longest, body.tree.leaf_x.size());
  }
  if (gap_.size() < longest) gap_.resize(longest);
  for (std::size_t k = 0; k < obstacles.capsules_W.size(); ++k) {
    against_capsule(X_WG, obstacles, static_cast<std::int32_t>(k), out);
  }
  for (std::size_t k = 0; k < obstacles.bodies.size(); ++k) {
    against_body(X_WG, obstacles, static_cast<std::int32_t>(k), out);
  }
}

}  // namespace hapticd::test
