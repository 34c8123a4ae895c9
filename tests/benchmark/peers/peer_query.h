// The collision structures of Bullet and FCL behind one plain interface: all pairs of a tool of
// spheres and of obstacles nearer than a margin. Both return pairs only, never the gap to what is
// further away. Plain data, because FCL's binary layout needs other Eigen settings than ours.
#pragma once

#include <array>
#include <memory>
#include <vector>

namespace hapticd::test {

struct PeerSphere {
  std::array<double, 3> p;
  double r;
};

struct PeerCapsule {
  std::array<double, 3> p_A, p_B;
  double r;
};

/// Rotation by rows and origin.
struct PeerPose {
  std::array<double, 9> R;
  std::array<double, 3> p;
};

struct PeerScene {
  std::vector<PeerSphere> tool_G;
  std::vector<PeerSphere> body_W;
  std::vector<PeerCapsule> capsules_W;
};

/// Two btDbvt, single precision (Bullet's default), built top down; the tool's stays in G. Against
/// the body both trees descend together, the tool's boxes turned on the fly, as
/// btCompoundCompoundCollisionAlgorithm does. Against a capsule the tool's tree is asked for the
/// box, in G, of the part of the capsule near the tool.
class BulletQuery {
 public:
  BulletQuery(const PeerScene& scene, double margin);
  ~BulletQuery();
  /// Number of pairs with gap < margin.
  int pairs(const PeerPose& X_WG);

 private:
  struct Trees;
  std::unique_ptr<Trees> trees_;
};

/// Two DynamicAABBTreeCollisionManagerd of spheres and capsules; the tool's objects are moved and
/// its tree updated at every query.
class FclQuery {
 public:
  FclQuery(const PeerScene& scene, double margin);
  ~FclQuery();
  /// Number of pairs with gap < margin.
  int pairs(const PeerPose& X_WG);

 private:
  struct Managers;
  std::unique_ptr<Managers> managers_;
};

/// Gap of two spheres is below `margin`.
[[nodiscard]] inline bool nearer(const std::array<double, 3>& a, double r_a,
                                 const std::array<double, 3>& b, double r_b, double margin) {
  const double x = a[0] - b[0];
  const double y = a[1] - b[1];
  const double z = a[2] - b[2];
  const double limit = r_a + r_b + margin;
  return x * x + y * y + z * z < limit * limit;
}

/// Point of the segment AB nearest to C.
[[nodiscard]] inline std::array<double, 3> nearest_point(const std::array<double, 3>& A,
                                                         const std::array<double, 3>& B,
                                                         const std::array<double, 3>& C) {
  double along = 0.0;
  double square = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    along += (C[k] - A[k]) * (B[k] - A[k]);
    square += (B[k] - A[k]) * (B[k] - A[k]);
  }
  const double s = along <= 0.0 ? 0.0 : along >= square ? 1.0 : along / square;
  return {A[0] + s * (B[0] - A[0]), A[1] + s * (B[1] - A[1]), A[2] + s * (B[2] - A[2])};
}

}  // namespace hapticd::test
