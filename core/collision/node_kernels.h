// The inner loops of the query: eight spheres at once. Each exists for AVX2 and in plain C++; both
// do the same operations per lane in the same order, so they give equal bits, and a query does the
// same work on every processor. Bit k of a mask speaks of lane k.
//   near      which bounds may be nearer than `radius`; compares squares, takes no roots
//   bounds    lower bounds of the gaps, m; +infinity in empty slots
//   *_gaps    exact gaps of spheres that are the surface: the bits of
//   core/collision/primitive_gap.h
// RT: yes; 15 to 30 ns, pair_gaps up to 100 ns.
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

/// Eight spheres that stand in someone else's memory.
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

/// Gaps of eight tool spheres against eight body spheres.
struct PairGaps {
  std::array<GapLanes, kTreeWidth> lanes;    ///< per tool sphere, where hit
  std::array<std::uint8_t, kTreeWidth> hit;  ///< per tool sphere, where any
};

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
  /// Pairs, of those in `tool_lanes` and `body_lanes`, with gap <= `radius`: returns the tool's
  /// spheres that have any, out.hit which. Both in B. `slack` covers the rounding of a gap, m.
  static unsigned pair_gaps(const SphereLanes& tool, unsigned tool_lanes, const SphereLanes& body,
                            unsigned body_lanes, double radius, double slack,
                            PairGaps& out) noexcept;
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
  static unsigned pair_gaps(const SphereLanes& tool, unsigned tool_lanes, const SphereLanes& body,
                            unsigned body_lanes, double radius, double slack,
                            PairGaps& out) noexcept;
};

}  // namespace hapticd
