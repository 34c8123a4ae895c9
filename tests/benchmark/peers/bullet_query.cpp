// See peer_query.h.
#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>
#include <cmath>

#include "tests/benchmark/peers/peer_query.h"

namespace hapticd::test {
namespace {

btVector3 bullet(const std::array<double, 3>& p) {
  return {static_cast<btScalar>(p[0]), static_cast<btScalar>(p[1]), static_cast<btScalar>(p[2])};
}

/// Leaves carry the index of their sphere.
void fill(btDbvt& tree, const std::vector<PeerSphere>& spheres) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): Bullet keeps user data as a pointer.
    tree.insert(btDbvtVolume::FromCR(bullet(spheres[i].p), static_cast<btScalar>(spheres[i].r)),
                reinterpret_cast<void*>(i));
  }
  tree.optimizeTopDown();
}

std::size_t index_of(const btDbvtNode* leaf) { return reinterpret_cast<std::size_t>(leaf->data); }

std::array<double, 3> placed(const PeerPose& X, const std::array<double, 3>& p) {
  std::array<double, 3> out;
  for (std::size_t k = 0; k < 3; ++k)
    out[k] = X.R[3 * k] * p[0] + X.R[3 * k + 1] * p[1] + X.R[3 * k + 2] * p[2] + X.p[k];
  return out;
}

std::array<double, 3> placed_back(const PeerPose& X, const std::array<double, 3>& p) {
  std::array<double, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    out[k] = X.R[k] * (p[0] - X.p[0]) + X.R[3 + k] * (p[1] - X.p[1]) + X.R[6 + k] * (p[2] - X.p[2]);
  }
  return out;
}

btTransform transform_of(const PeerPose& X) {
  btScalar R[9];
  std::transform(X.R.begin(), X.R.end(), R, [](double r) { return static_cast<btScalar>(r); });
  return btTransform(btMatrix3x3(R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]),
                     bullet(X.p));
}

/// Collects the leaves a volume query reports.
struct LeafCollector : btDbvt::ICollide {
  std::vector<const btDbvtNode*> leaves;
  // NOLINTNEXTLINE(readability-identifier-naming): Bullet's name.
  void Process(const btDbvtNode* leaf) override { leaves.push_back(leaf); }
  using btDbvt::ICollide::Process;
};

}  // namespace

struct BulletQuery::Trees {
  PeerScene scene;
  double margin;
  btDbvt tool, body;
  double reach = 0.0;
  btNodeStack stack;
  LeafCollector found;
  std::vector<std::pair<const btDbvtNode*, const btDbvtNode*>> pairs;

  int against_body(const PeerPose& X_WG);
  int against_capsule(const PeerPose& X_WG, const PeerCapsule& capsule);
};

int BulletQuery::Trees::against_body(const PeerPose& X_WG) {
  const btTransform X = transform_of(X_WG);
  const btMatrix3x3 absolute = X.getBasis().absolute();
  const auto grown = static_cast<btScalar>(margin);
  int count = 0;
  pairs.assign(1, {tool.m_root, body.m_root});
  while (!pairs.empty()) {
    const auto [a, b] = pairs.back();
    pairs.pop_back();
    const btVector3 centre = X(a->volume.Center());
    const btVector3 extents = absolute * a->volume.Extents() + btVector3(grown, grown, grown);
    if (!Intersect(btDbvtVolume::FromCE(centre, extents), b->volume)) continue;
    if (a->isinternal() && b->isinternal()) {
      for (const btDbvtNode* child_a : a->childs)
        for (const btDbvtNode* child_b : b->childs) pairs.emplace_back(child_a, child_b);
    } else if (a->isinternal()) {
      for (const btDbvtNode* child : a->childs) pairs.emplace_back(child, b);
    } else if (b->isinternal()) {
      for (const btDbvtNode* child : b->childs) pairs.emplace_back(a, child);
    } else {
      const PeerSphere& sphere = scene.tool_G[index_of(a)];
      const PeerSphere& other = scene.body_W[index_of(b)];
      count += nearer(placed(X_WG, sphere.p), sphere.r, other.p, other.r, margin) ? 1 : 0;
    }
  }
  return count;
}

int BulletQuery::Trees::against_capsule(const PeerPose& X_WG, const PeerCapsule& capsule) {
  const std::array<double, 3> A = placed_back(X_WG, capsule.p_A);
  const std::array<double, 3> B = placed_back(X_WG, capsule.p_B);
  // Only the part of the axis within reach of the tool's origin.
  const std::array<double, 3> nearest = nearest_point(A, B, {0, 0, 0});
  const double near = reach + capsule.r + margin;
  const double half_square =
      near * near - nearest[0] * nearest[0] - nearest[1] * nearest[1] - nearest[2] * nearest[2];
  if (half_square <= 0.0) return 0;
  const double length = std::hypot(B[0] - A[0], B[1] - A[1], B[2] - A[2]);
  std::array<double, 3> low;
  std::array<double, 3> high;
  for (std::size_t k = 0; k < 3; ++k) {
    const double half = std::sqrt(half_square) * std::abs(B[k] - A[k]) / length;
    low[k] = std::max(nearest[k] - half, std::min(A[k], B[k])) - capsule.r - margin;
    high[k] = std::min(nearest[k] + half, std::max(A[k], B[k])) + capsule.r + margin;
  }
  found.leaves.clear();
  tool.collideTVNoStackAlloc(tool.m_root, btDbvtVolume::FromMM(bullet(low), bullet(high)), stack,
                             found);
  int count = 0;
  for (const btDbvtNode* leaf : found.leaves) {
    const PeerSphere& sphere = scene.tool_G[index_of(leaf)];
    count += nearer(sphere.p, sphere.r, nearest_point(A, B, sphere.p), capsule.r, margin) ? 1 : 0;
  }
  return count;
}

BulletQuery::BulletQuery(const PeerScene& scene, double margin)
    : trees_(std::make_unique<Trees>()) {
  trees_->scene = scene;
  trees_->margin = margin;
  fill(trees_->tool, scene.tool_G);
  if (!scene.body_W.empty()) fill(trees_->body, scene.body_W);
  for (const PeerSphere& sphere : scene.tool_G) {
    trees_->reach =
        std::max(trees_->reach, std::hypot(sphere.p[0], sphere.p[1], sphere.p[2]) + sphere.r);
  }
}

BulletQuery::~BulletQuery() = default;

int BulletQuery::pairs(const PeerPose& X_WG) {
  int count = trees_->body.m_root != nullptr ? trees_->against_body(X_WG) : 0;
  for (const PeerCapsule& capsule : trees_->scene.capsules_W)
    count += trees_->against_capsule(X_WG, capsule);
  return count;
}

}  // namespace hapticd::test
