// Exact gaps of the two primitive pairs: sphere-capsule (Eq. 1-4) and sphere-sphere. All vectors
// have the axes of W and start at the graphic tool's origin G, so that accuracy is that of the
// distances at hand, not of the scene's distance from W's origin. Every query ends in these
// operations, in this order (core/collision/node_kernels.h repeats them eight at a time): same
// pair, same bits. RT: yes, about 10 ns each.
#pragma once

#include "core/collision/contact.h"
#include "core/collision/obstacles.h"
#include "core/geometry/closest_point.h"

namespace hapticd {

/// R_AB of any finite q != 0; orthogonal to rounding even where |q| is not quite 1, so that a pose
/// and its inverse agree about every distance.
[[nodiscard]] inline Matrix3 rotation_matrix(const Quaternion& q) noexcept {
  const double w = q.w();
  const double x = q.x();
  const double y = q.y();
  const double z = q.z();
  const double s = 2.0 / ((w * w + x * x) + (y * y + z * z));
  Matrix3 R;
  R << 1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),  //
      s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x),   //
      s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y);
  return R;
}

/// Numbers of a vector, for loops that are to become lanes.
struct Components {
  double x, y, z;
};

/// Component `row` of R v, summed in a fixed order.
[[nodiscard]] inline double row_times(const Matrix3& R, int row, const Components& v) noexcept {
  return (R(row, 0) * v.x + R(row, 1) * v.y) + R(row, 2) * v.z;
}

/// R v.
[[nodiscard]] inline Vector3 rotate(const Matrix3& R, const Vector3& v) noexcept {
  const Components c{v.x(), v.y(), v.z()};
  return {row_times(R, 0, c), row_times(R, 1, c), row_times(R, 2, c)};
}

/// Where the tool is.
struct ToolPlacement {
  Matrix3 R_WG;
  Vector3 p_WG;
};

[[nodiscard]] inline ToolPlacement place_tool(const Pose& X_WG) noexcept {
  return {rotation_matrix(X_WG.q), X_WG.p};
}

/// A capsule seen from G.
struct PlacedCapsule {
  Vector3 p_GA_W;
  Vector3 p_GB_W;
  double r;
};

[[nodiscard]] inline PlacedCapsule place_capsule(const Capsule& capsule_W,
                                                 const Vector3& p_WG) noexcept {
  return {capsule_W.p_A - p_WG, capsule_W.p_B - p_WG, capsule_W.r};
}

/// The tool seen from a body's frame B.
struct PlacedBody {
  Matrix3 R_WB;
  Matrix3 R_BG;
  Vector3 p_BG;
};

[[nodiscard]] inline PlacedBody place_body(const Pose& X_WB,
                                           const ToolPlacement& placement) noexcept {
  const Matrix3 R_WB = rotation_matrix(X_WB.q);
  const Matrix3 R_BW = R_WB.transpose();
  Matrix3 R_BG;
  for (int k = 0; k < 3; ++k) R_BG.col(k) = rotate(R_BW, placement.R_WG.col(k));
  return {R_WB, R_BG, rotate(R_BW, placement.p_WG - X_WB.p)};
}

/// p_BC of a tool sphere's centre p_GC.
[[nodiscard]] inline Vector3 to_body(const PlacedBody& body, const Vector3& p_GC) noexcept {
  return rotate(body.R_BG, p_GC) + body.p_BG;
}

/// One pair of primitives.
struct PrimitiveGap {
  Vector3 offset;   ///< from the obstacle's nearest point to the tool sphere's centre, m; axes of W
                    ///< for a capsule, of B for a body
  double distance;  ///< |offset|, m
  double gap;       ///< distance less both radii, m
  double lambda;    ///< along the capsule's axis; 0 for a body
};

/// Tool sphere with centre `p_GC_W` and radius `r` against a capsule. About 10 ns.
[[nodiscard]] inline PrimitiveGap gap_to_capsule(const Vector3& p_GC_W, double r,
                                                 const PlacedCapsule& capsule) noexcept {
  const SegmentPoint nearest = closest_point_on_segment(capsule.p_GA_W, capsule.p_GB_W, p_GC_W);
  return {nearest.offset, nearest.distance, nearest.distance - (r + capsule.r), nearest.lambda};
}

/// Tool sphere with centre `p_BC` and radius `r` against `sphere_B`, a sphere of the body.
[[nodiscard]] inline PrimitiveGap gap_to_body_sphere(const Vector3& p_BC, double r,
                                                     const Sphere& sphere_B) noexcept {
  const Vector3 offset = p_BC - sphere_B.p;
  const double distance = length(offset);
  return {offset, distance, distance - (r + sphere_B.r), 0.0};
}

/// A tool sphere on its way into a contact: centre seen from G in the axes of W, radius, and G in
/// W.
struct PlacedSphere {
  Vector3 p_GC_W;
  double r;
  Vector3 p_WG;
};

/// The contact of a pair whose normal is known.
[[nodiscard]] inline Contact make_contact(const ContactKey& key, const PrimitiveGap& pair,
                                          const Vector3& nhat_OG_W,
                                          const PlacedSphere& sphere) noexcept {
  return {key, nhat_OG_W, (sphere.p_GC_W - sphere.r * nhat_OG_W) + sphere.p_WG, pair.gap,
          pair.lambda};
}

/// From obstacle to tool; a centre on the capsule's axis `axis_W` leaves along a fixed normal.
[[nodiscard]] inline Vector3 capsule_normal(const PrimitiveGap& pair,
                                            const Vector3& axis_W) noexcept {
  return direction_or_fallback(pair.offset, pair.distance, axis_W);
}

/// From obstacle to tool; concentric spheres part along +y of W.
[[nodiscard]] inline Vector3 body_normal(const PrimitiveGap& pair, const Matrix3& R_WB) noexcept {
  if (pair.distance < kMinLength) [[unlikely]]
    return {0.0, 1.0, 0.0};
  return rotate(R_WB, pair.offset * (1.0 / pair.distance));
}

}  // namespace hapticd
