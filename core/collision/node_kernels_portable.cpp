// The plain loops. See node_kernels.h.
#include <cmath>

#include "core/collision/node_kernels.h"

namespace hapticd {
namespace {

constexpr std::size_t kWidth = kTreeWidth;

/// Square of the distance of sphere `i` from the capsule's axis.
double distance_squared(const SphereLanes& spheres, const CapsuleProbe& probe,
                        std::size_t i) noexcept {
  const double dx = spheres.x[i] - probe.p_A.x();
  const double dy = spheres.y[i] - probe.p_A.y();
  const double dz = spheres.z[i] - probe.p_A.z();
  double lambda =
      (dx * probe.axis_inverse.x() + dy * probe.axis_inverse.y()) + dz * probe.axis_inverse.z();
  lambda = lambda > 0.0 ? lambda : 0.0;
  lambda = lambda < 1.0 ? lambda : 1.0;
  const double ox = dx - lambda * probe.axis.x();
  const double oy = dy - lambda * probe.axis.y();
  const double oz = dz - lambda * probe.axis.z();
  return (ox * ox + oy * oy) + oz * oz;
}

/// Square of the distance of sphere `i` from the probe's centre.
double distance_squared(const SphereLanes& spheres, const SphereProbe& probe,
                        std::size_t i) noexcept {
  const double dx = spheres.x[i] - probe.p.x();
  const double dy = spheres.y[i] - probe.p.y();
  const double dz = spheres.z[i] - probe.p.z();
  return (dx * dx + dy * dy) + dz * dz;
}

template <typename Probe>
unsigned near_mask(const SphereLanes& spheres, const Probe& probe, double radius) noexcept {
  const double inflated = radius + probe.inflation;
  unsigned mask = 0;
  for (std::size_t i = 0; i < kWidth; ++i) {
    // An empty slot gives -infinity, or NaN where the radius is infinite: neither is above 0.
    double reach = spheres.r[i] + inflated;
    reach = reach > 0.0 ? reach : 0.0;
    const bool is_near = distance_squared(spheres, probe, i) < reach * reach;
    mask |= static_cast<unsigned>(is_near) << i;
  }
  return mask;
}

template <typename Probe>
void lower_bounds(const SphereLanes& spheres, const Probe& probe, Lanes& lower) noexcept {
  for (std::size_t i = 0; i < kWidth; ++i) {
    lower[i] = std::sqrt(distance_squared(spheres, probe, i)) - (spheres.r[i] + probe.inflation);
  }
}

void set(PointLanes& lanes, std::size_t k, const Vector3& p) noexcept {
  lanes.x[k] = p.x();
  lanes.y[k] = p.y();
  lanes.z[k] = p.z();
}

void set(GapLanes& lanes, std::size_t k, const PrimitiveGap& pair) noexcept {
  lanes.x[k] = pair.offset.x();
  lanes.y[k] = pair.offset.y();
  lanes.z[k] = pair.offset.z();
  lanes.distance[k] = pair.distance;
  lanes.gap[k] = pair.gap;
}

}  // namespace

unsigned PortableKernels::near(const SphereLanes& spheres, const CapsuleProbe& probe,
                               double radius) noexcept {
  return near_mask(spheres, probe, radius);
}

unsigned PortableKernels::near(const SphereLanes& spheres, const SphereProbe& probe,
                               double radius) noexcept {
  return near_mask(spheres, probe, radius);
}

void PortableKernels::bounds(const SphereLanes& spheres, const CapsuleProbe& probe,
                             Lanes& lower) noexcept {
  lower_bounds(spheres, probe, lower);
}

void PortableKernels::bounds(const SphereLanes& spheres, const SphereProbe& probe,
                             Lanes& lower) noexcept {
  lower_bounds(spheres, probe, lower);
}

void PortableKernels::to_body(const SphereTreeNode& tool, const PlacedBody& body,
                              PointLanes& p_BC) noexcept {
  for (std::size_t k = 0; k < kWidth; ++k) {
    set(p_BC, k, hapticd::to_body(body, {tool.x[k], tool.y[k], tool.z[k]}));
  }
}

unsigned PortableKernels::capsule_gaps(const SphereTreeNode& tool, unsigned lanes,
                                       const Matrix3& R_WG, const PlacedCapsule& capsule,
                                       double radius, CapsuleGaps& out) noexcept {
  unsigned hit = 0;
  for (std::size_t k = 0; k < kWidth; ++k) {
    const Vector3 p_GC_W = rotate(R_WG, {tool.x[k], tool.y[k], tool.z[k]});
    const PrimitiveGap pair = gap_to_capsule(p_GC_W, tool.r[k], capsule);
    set(out.p_GC_W, k, p_GC_W);
    set(out.lanes, k, pair);
    out.lambda[k] = pair.lambda;
    hit |= static_cast<unsigned>(pair.gap <= radius) << k;
  }
  return hit & lanes;
}

unsigned PortableKernels::near_box(const PointLanes& p_BC, const Lanes& r, const NodeBox& box,
                                   double radius) noexcept {
  const auto outside = [](double lower, double upper, double x) {
    const double below = lower - x;
    const double above = x - upper;
    const double farther = below > above ? below : above;
    return farther > 0.0 ? farther : 0.0;
  };
  unsigned mask = 0;
  for (std::size_t i = 0; i < kWidth; ++i) {
    double reach = r[i] + radius;
    reach = reach > 0.0 ? reach : 0.0;
    const double dx = outside(box.lower.x(), box.upper.x(), p_BC.x[i]);
    const double dy = outside(box.lower.y(), box.upper.y(), p_BC.y[i]);
    const double dz = outside(box.lower.z(), box.upper.z(), p_BC.z[i]);
    mask |= static_cast<unsigned>((dx * dx + dy * dy) + dz * dz <= reach * reach) << i;
  }
  return mask;
}

PairMask PortableKernels::near_pairs(const SphereLanes& tool, unsigned tool_lanes,
                                     const SphereLanes& body, unsigned body_lanes,
                                     double radius) noexcept {
  PairMask mask = 0;
  for (std::size_t k = 0; k < kWidth; ++k) {
    if ((body_lanes >> k & 1U) == 0) continue;
    const SphereProbe probe{{body.x[k], body.y[k], body.z[k]}, body.r[k]};
    mask |= PairMask{near_mask(tool, probe, radius) & tool_lanes} << (kWidth * k);
  }
  return mask;
}

}  // namespace hapticd
