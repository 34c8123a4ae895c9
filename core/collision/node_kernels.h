// The inner loops of the query: eight spheres at once. Each exists for AVX2 and in plain C++; both
// do the same operations per lane in the same order, so they give equal bits, and a query does the
// same work on every processor. Bit k of a mask speaks of lane k.
//   near          which spheres may be nearer than `radius`; compares squares, takes no roots
//   near_pairs    the same of eight spheres against eight
//   near_box      the same against a box
//   bounds        lower bounds of the gaps, m; +infinity in empty slots
//   capsule_gaps  exact gaps of spheres that are the surface: the bits of
//                 core/collision/primitive_gap.h
// RT: yes; 5 to 30 ns.
#pragma once

#include <array>
#include <cstdint>

#include "core/collision/probe.h"

namespace hapticd {

/// One number per child of a node.
using Lanes = std::array<double, kTreeWidth>;

/// Eight points, m.
struct alignas(32) PointLanes {
  Lanes x, y, z;

  [[nodiscard]] Vector3 operator[](std::size_t k) const noexcept { return {x[k], y[k], z[k]}; }
};

/// Eight spheres in someone else's memory.
struct SphereLanes {
  const Lanes& x;
  const Lanes& y;
  const Lanes& z;
  const Lanes& r;
};

[[nodiscard]] inline SphereLanes lanes_of(const SphereTreeNode& node) noexcept {
  return {node.x, node.y, node.z, node.r};
}

/// Tool spheres against a capsule, or one tool sphere against the spheres of a body.
struct alignas(32) GapLanes {
  Lanes x, y, z;   ///< PrimitiveGap::offset, m
  Lanes distance;  ///< m
  Lanes gap;       ///< m

  [[nodiscard]] PrimitiveGap pair(std::size_t k, double lambda) const noexcept {
    return {{x[k], y[k], z[k]}, distance[k], gap[k], lambda};
  }
};

/// Gaps of a tool's node against a capsule.
struct CapsuleGaps {
  PointLanes p_GC_W;
  GapLanes lanes;
  Lanes lambda;
};

/// Pairs of eight spheres and eight others: bit 8 k + i speaks of the tool's i and the body's k.
using PairMask = std::uint64_t;

/// The tool's spheres that are near to the body's `k`.
[[nodiscard]] inline unsigned tool_lanes(PairMask mask, int k) noexcept {
  return static_cast<unsigned>(mask >> (kTreeWidth * k)) & 0xFFU;
}

/// The tool's spheres that are near to any.
[[nodiscard]] inline unsigned tool_lanes(PairMask mask) noexcept {
  mask |= mask >> 32U;
  mask |= mask >> 16U;
  return static_cast<unsigned>(mask | mask >> 8U) & 0xFFU;
}

/// The body's spheres that are near to the tool's `i`: one bit of each byte, moved together.
[[nodiscard]] inline unsigned body_lanes(PairMask mask, int i) noexcept {
  return static_cast<unsigned>((mask >> i & 0x0101010101010101U) * 0x0102040810204080U >> 56U);
}

/// Plain C++.
struct PortableKernels {
  static unsigned near(const SphereLanes& spheres, const CapsuleProbe& probe,
                       double radius) noexcept;
  static unsigned near(const SphereLanes& spheres, const SphereProbe& probe,
                       double radius) noexcept;
  static void bounds(const SphereLanes& spheres, const CapsuleProbe& probe, Lanes& lower) noexcept;
  static void bounds(const SphereLanes& spheres, const SphereProbe& probe, Lanes& lower) noexcept;
  /// to_body() of the centres of a tool's node.
  static void to_body(const SphereTreeNode& tool, const PlacedBody& body,
                      PointLanes& p_BC) noexcept;
  /// Returns the children of `tool`, of those in `lanes`, with gap <= `radius`.
  static unsigned capsule_gaps(const SphereTreeNode& tool, unsigned lanes, const Matrix3& R_WG,
                               const PlacedCapsule& capsule, double radius,
                               CapsuleGaps& out) noexcept;
  /// Pairs, of those in `tool_lanes` and `body_lanes`, that may have a gap below `radius`. Both in
  /// B.
  static PairMask near_pairs(const SphereLanes& tool, unsigned tool_lanes, const SphereLanes& body,
                             unsigned body_lanes, double radius) noexcept;
  /// Spheres with `r` around `p_BC` that may have a gap below `radius` to a sphere inside `box`;
  /// all with their centre inside, for nothing is known of how deep they are. Both in B.
  static unsigned near_box(const PointLanes& p_BC, const Lanes& r, const NodeBox& box,
                           double radius) noexcept;
};

/// Four lanes at a time; only where avx2_available().
struct Avx2Kernels {
  static unsigned near(const SphereLanes& spheres, const CapsuleProbe& probe,
                       double radius) noexcept;
  static unsigned near(const SphereLanes& spheres, const SphereProbe& probe,
                       double radius) noexcept;
  static void bounds(const SphereLanes& spheres, const CapsuleProbe& probe, Lanes& lower) noexcept;
  static void bounds(const SphereLanes& spheres, const SphereProbe& probe, Lanes& lower) noexcept;
  static void to_body(const SphereTreeNode& tool, const PlacedBody& body,
                      PointLanes& p_BC) noexcept;
  static unsigned capsule_gaps(const SphereTreeNode& tool, unsigned lanes, const Matrix3& R_WG,
                               const PlacedCapsule& capsule, double radius,
                               CapsuleGaps& out) noexcept;
  static PairMask near_pairs(const SphereLanes& tool, unsigned tool_lanes, const SphereLanes& body,
                             unsigned body_lanes, double radius) noexcept;
  /// Spheres with `r` around `p_BC` that may have a gap below `radius` to a sphere inside `box`;
  /// all with their centre inside, for nothing is known of how deep they are. Both in B.
  static unsigned near_box(const PointLanes& p_BC, const Lanes& r, const NodeBox& box,
                           double radius) noexcept;
};

}  // namespace hapticd
