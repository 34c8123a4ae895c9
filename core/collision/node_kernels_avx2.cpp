// Four doubles per instruction. Only functions marked with the target use it, so that nothing
// compiled here can run on a processor without it. See node_kernels.h.
#include <immintrin.h>

#include <bit>

#include "core/collision/node_kernels.h"

namespace hapticd {
namespace {

/// Lanes per instruction.
constexpr std::size_t kStep = 4;
constexpr std::size_t kWidth = kTreeWidth;

struct Vector3x4 {
  __m256d x, y, z;
};

[[gnu::target("avx2"), gnu::always_inline]] inline __m256d set(double value) noexcept {
  return _mm256_set1_pd(value);
}

[[gnu::target("avx2"), gnu::always_inline]] inline Vector3x4 broadcast(const Vector3& v) noexcept {
  return {set(v.x()), set(v.y()), set(v.z())};
}

[[gnu::target("avx2"), gnu::always_inline]] inline __m256d load(const Lanes& lanes,
                                                                std::size_t k) noexcept {
  return _mm256_load_pd(&lanes[k]);
}

[[gnu::target("avx2"), gnu::always_inline]] inline void store(Lanes& lanes, std::size_t k,
                                                              __m256d value) noexcept {
  _mm256_store_pd(&lanes[k], value);
}

[[gnu::target("avx2"), gnu::always_inline]] inline Vector3x4 centres(const SphereLanes& spheres,
                                                                     std::size_t k) noexcept {
  return {load(spheres.x, k), load(spheres.y, k), load(spheres.z, k)};
}

[[gnu::target("avx2"), gnu::always_inline]] inline Vector3x4 add(const Vector3x4& a,
                                                                 const Vector3x4& b) noexcept {
  return {_mm256_add_pd(a.x, b.x), _mm256_add_pd(a.y, b.y), _mm256_add_pd(a.z, b.z)};
}

[[gnu::target("avx2"), gnu::always_inline]] inline Vector3x4 subtract(const Vector3x4& a,
                                                                      const Vector3x4& b) noexcept {
  return {_mm256_sub_pd(a.x, b.x), _mm256_sub_pd(a.y, b.y), _mm256_sub_pd(a.z, b.z)};
}

[[gnu::target("avx2"), gnu::always_inline]] inline Vector3x4 scale(__m256d s,
                                                                   const Vector3x4& a) noexcept {
  return {_mm256_mul_pd(s, a.x), _mm256_mul_pd(s, a.y), _mm256_mul_pd(s, a.z)};
}

[[gnu::target("avx2"), gnu::always_inline]] inline __m256d dot(const Vector3x4& a,
                                                               const Vector3x4& b) noexcept {
  return _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(a.x, b.x), _mm256_mul_pd(a.y, b.y)),
                       _mm256_mul_pd(a.z, b.z));
}

/// R v of four vectors, as rotate() of primitive_gap.h.
[[gnu::target("avx2"), gnu::always_inline]] inline Vector3x4 rotate(const Matrix3& R,
                                                                    const Vector3x4& v) noexcept {
  return {dot({set(R(0, 0)), set(R(0, 1)), set(R(0, 2))}, v),
          dot({set(R(1, 0)), set(R(1, 1)), set(R(1, 2))}, v),
          dot({set(R(2, 0)), set(R(2, 1)), set(R(2, 2))}, v)};
}

[[gnu::target("avx2"), gnu::always_inline]] inline void store(PointLanes& lanes, std::size_t k,
                                                              const Vector3x4& p) noexcept {
  store(lanes.x, k, p.x);
  store(lanes.y, k, p.y);
  store(lanes.z, k, p.z);
}

[[gnu::target("avx2"), gnu::always_inline]] inline __m256d clamp_to_unit(__m256d value) noexcept {
  return _mm256_min_pd(_mm256_max_pd(value, _mm256_setzero_pd()), set(1.0));
}

[[gnu::target("avx2"), gnu::always_inline]] inline __m256d distance_squared(
    const Vector3x4& p, const CapsuleProbe& probe) noexcept {
  const Vector3x4 d = subtract(p, broadcast(probe.p_A));
  const __m256d lambda = clamp_to_unit(dot(d, broadcast(probe.axis_inverse)));
  const Vector3x4 o = subtract(d, scale(lambda, broadcast(probe.axis)));
  return dot(o, o);
}

[[gnu::target("avx2"), gnu::always_inline]] inline __m256d distance_squared(
    const Vector3x4& p, const SphereProbe& probe) noexcept {
  const Vector3x4 d = subtract(p, broadcast(probe.p));
  return dot(d, d);
}

/// Four bits: square < reach^2.
[[gnu::target("avx2"), gnu::always_inline]] inline unsigned below_square(__m256d square,
                                                                         __m256d reach) noexcept {
  const __m256d is_below = _mm256_cmp_pd(square, _mm256_mul_pd(reach, reach), _CMP_LT_OQ);
  return static_cast<unsigned>(_mm256_movemask_pd(is_below));
}

template <typename Probe>
[[gnu::target("avx2"), gnu::always_inline]] inline unsigned near_mask(const SphereLanes& spheres,
                                                                      const Probe& probe,
                                                                      double radius) noexcept {
  const __m256d inflated = set(radius + probe.inflation);
  unsigned mask = 0;
  for (std::size_t k = 0; k < kWidth; k += kStep) {
    const __m256d reach = _mm256_add_pd(load(spheres.r, k), inflated);
    const __m256d positive = _mm256_max_pd(reach, _mm256_setzero_pd());
    mask |= below_square(distance_squared(centres(spheres, k), probe), positive) << k;
  }
  return mask;
}

template <typename Probe>
[[gnu::target("avx2"), gnu::always_inline]] inline void lower_bounds(const SphereLanes& spheres,
                                                                     const Probe& probe,
                                                                     Lanes& lower) noexcept {
  for (std::size_t k = 0; k < kWidth; k += kStep) {
    const __m256d distance = _mm256_sqrt_pd(distance_squared(centres(spheres, k), probe));
    const __m256d inflated = _mm256_add_pd(load(spheres.r, k), set(probe.inflation));
    _mm256_storeu_pd(&lower[k], _mm256_sub_pd(distance, inflated));
  }
}

/// Writes four lanes of `out` from `k` on; four bits: gap <= radius.
[[gnu::target("avx2"), gnu::always_inline]] inline unsigned store_gap(const Vector3x4& offset,
                                                                      __m256d square, __m256d radii,
                                                                      double radius, std::size_t k,
                                                                      GapLanes& out) noexcept {
  const __m256d distance = _mm256_sqrt_pd(square);
  const __m256d gap = _mm256_sub_pd(distance, radii);
  store(out.x, k, offset.x);
  store(out.y, k, offset.y);
  store(out.z, k, offset.z);
  store(out.distance, k, distance);
  store(out.gap, k, gap);
  return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(gap, set(radius), _CMP_LE_OQ)));
}

/// How far `x` lies outside of an interval.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256d outside(double lower, double upper,
                                                                   __m256d x) noexcept {
  const __m256d farther = _mm256_max_pd(_mm256_sub_pd(set(lower), x), _mm256_sub_pd(x, set(upper)));
  return _mm256_max_pd(farther, _mm256_setzero_pd());
}

}  // namespace

[[gnu::target("avx2")]] unsigned Avx2Kernels::near(const SphereLanes& spheres,
                                                   const CapsuleProbe& probe,
                                                   double radius) noexcept {
  return near_mask(spheres, probe, radius);
}

[[gnu::target("avx2")]] unsigned Avx2Kernels::near(const SphereLanes& spheres,
                                                   const SphereProbe& probe,
                                                   double radius) noexcept {
  return near_mask(spheres, probe, radius);
}

[[gnu::target("avx2")]] void Avx2Kernels::bounds(const SphereLanes& spheres,
                                                 const CapsuleProbe& probe, Lanes& lower) noexcept {
  lower_bounds(spheres, probe, lower);
}

[[gnu::target("avx2")]] void Avx2Kernels::bounds(const SphereLanes& spheres,
                                                 const SphereProbe& probe, Lanes& lower) noexcept {
  lower_bounds(spheres, probe, lower);
}

[[gnu::target("avx2")]] void Avx2Kernels::to_body(const SphereTreeNode& tool,
                                                  const PlacedBody& body,
                                                  PointLanes& p_BC) noexcept {
  for (std::size_t k = 0; k < kWidth; k += kStep) {
    const Vector3x4 p_GC = centres(lanes_of(tool), k);
    store(p_BC, k, add(rotate(body.R_BG, p_GC), broadcast(body.p_BG)));
  }
}

[[gnu::target("avx2")]] unsigned Avx2Kernels::capsule_gaps(const SphereTreeNode& tool,
                                                           unsigned lanes, const Matrix3& R_WG,
                                                           const PlacedCapsule& capsule,
                                                           double radius,
                                                           CapsuleGaps& out) noexcept {
  const Vector3x4 a = broadcast(capsule.p_GA_W);
  const Vector3x4 ab = broadcast(capsule.p_GB_W - capsule.p_GA_W);
  const __m256d square = dot(ab, ab);
  const __m256d has_length = _mm256_cmp_pd(square, set(kMinLength * kMinLength), _CMP_GE_OQ);
  unsigned hit = 0;
  for (std::size_t k = 0; k < kWidth; k += kStep) {
    const Vector3x4 c = rotate(R_WG, centres(lanes_of(tool), k));
    const Vector3x4 ac = subtract(c, a);
    const __m256d raw = _mm256_and_pd(_mm256_div_pd(dot(ac, ab), square), has_length);
    const __m256d lambda = clamp_to_unit(raw);
    const Vector3x4 offset = subtract(ac, scale(lambda, ab));
    store(out.p_GC_W, k, c);
    store(out.lambda, k, lambda);
    const __m256d radii = _mm256_add_pd(load(tool.r, k), set(capsule.r));
    hit |= store_gap(offset, dot(offset, offset), radii, radius, k, out.lanes) << k;
  }
  return hit & lanes;
}

[[gnu::target("avx2")]] unsigned Avx2Kernels::near_box(const PointLanes& p_BC, const Lanes& r,
                                                       const NodeBox& box, double radius) noexcept {
  unsigned mask = 0;
  for (std::size_t k = 0; k < kWidth; k += kStep) {
    const __m256d reach = _mm256_add_pd(load(r, k), set(radius));
    const __m256d positive = _mm256_max_pd(reach, _mm256_setzero_pd());
    const Vector3x4 d{outside(box.lower.x(), box.upper.x(), load(p_BC.x, k)),
                      outside(box.lower.y(), box.upper.y(), load(p_BC.y, k)),
                      outside(box.lower.z(), box.upper.z(), load(p_BC.z, k))};
    const __m256d is_near = _mm256_cmp_pd(dot(d, d), _mm256_mul_pd(positive, positive), _CMP_LE_OQ);
    mask |= static_cast<unsigned>(_mm256_movemask_pd(is_near)) << k;
  }
  return mask;
}

[[gnu::target("avx2")]] PairMask Avx2Kernels::near_pairs(const SphereLanes& tool,
                                                         unsigned tool_lanes,
                                                         const SphereLanes& body,
                                                         unsigned body_lanes,
                                                         double radius) noexcept {
  PairMask mask = 0;
  for (unsigned rest = body_lanes; rest != 0; rest &= rest - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(rest));
    const SphereProbe probe{{body.x[k], body.y[k], body.z[k]}, body.r[k]};
    mask |= PairMask{near_mask(tool, probe, radius) & tool_lanes} << (kWidth * k);
  }
  return mask;
}

}  // namespace hapticd
