// See avx2_brute_force.h.
#include "tests/benchmark/avx2_brute_force.h"
#include "tests/support/pose_composition.h"

#include <immintrin.h>

#include <algorithm>
#include <bit>

namespace hapticd::test {

Avx2BruteForce::Avx2BruteForce(const SphereTreeView& tool) : tool_(tool) {}

void Avx2BruteForce::add(const ContactKey& key, const Pose& X_WG, const ObstaclesView& obstacles,
                         double margin, ContactSet& out) {
  const Contact contact = evaluate_contact(key, {tool_, X_WG}, obstacles);
  out.minimum_gap = std::min(out.minimum_gap, contact.gap);
  if (contact.gap < margin) out.contacts.push_back(contact);
}

[[gnu::target("avx2")]] void Avx2BruteForce::against_capsule(const Pose& X_WG,
                                                             const ObstaclesView& obstacles,
                                                             std::int32_t capsule, double margin,
                                                             ContactSet& out) {
  const Capsule& capsule_W = obstacles.capsules_W[static_cast<std::size_t>(capsule)];
  const Pose X_GW = inverse(X_WG);
  const Vector3 a = transform(X_GW, capsule_W.p_A);
  const Vector3 e = transform(X_GW, capsule_W.p_B) - a;
  const Vector3 u = e / e.squaredNorm();
  const __m256d ax = _mm256_set1_pd(a.x()), ay = _mm256_set1_pd(a.y()), az = _mm256_set1_pd(a.z());
  const __m256d ex = _mm256_set1_pd(e.x()), ey = _mm256_set1_pd(e.y()), ez = _mm256_set1_pd(e.z());
  const __m256d ux = _mm256_set1_pd(u.x()), uy = _mm256_set1_pd(u.y()), uz = _mm256_set1_pd(u.z());
  double radius = std::max(margin, out.minimum_gap) + capsule_W.r;
  for (std::size_t i = 0; i + 4 <= tool_.leaf_x.size(); i += 4) {
    const __m256d dx = _mm256_sub_pd(_mm256_loadu_pd(&tool_.leaf_x[i]), ax);
    const __m256d dy = _mm256_sub_pd(_mm256_loadu_pd(&tool_.leaf_y[i]), ay);
    const __m256d dz = _mm256_sub_pd(_mm256_loadu_pd(&tool_.leaf_z[i]), az);
    __m256d s = _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(dx, ux), _mm256_mul_pd(dy, uy)),
                              _mm256_mul_pd(dz, uz));
    s = _mm256_min_pd(_mm256_max_pd(s, _mm256_setzero_pd()), _mm256_set1_pd(1.0));
    const __m256d ox = _mm256_sub_pd(dx, _mm256_mul_pd(s, ex));
    const __m256d oy = _mm256_sub_pd(dy, _mm256_mul_pd(s, ey));
    const __m256d oz = _mm256_sub_pd(dz, _mm256_mul_pd(s, ez));
    const __m256d square = _mm256_add_pd(
        _mm256_add_pd(_mm256_mul_pd(ox, ox), _mm256_mul_pd(oy, oy)), _mm256_mul_pd(oz, oz));
    const __m256d near = _mm256_add_pd(_mm256_loadu_pd(&tool_.leaf_r[i]), _mm256_set1_pd(radius));
    auto hits = static_cast<unsigned>(
        _mm256_movemask_pd(_mm256_cmp_pd(square, _mm256_mul_pd(near, near), _CMP_LT_OQ)));
    for (; hits != 0; hits &= hits - 1) {
      const auto sphere = static_cast<TreeSphereId>(i) + std::countr_zero(hits);
      add({ObstacleKind::kCapsule, capsule, sphere, 0}, X_WG, obstacles, margin, out);
      radius = std::max(margin, out.minimum_gap) + capsule_W.r;
    }
  }
}

[[gnu::target("avx2")]] void Avx2BruteForce::against_body(const Pose& X_WG,
                                                          const ObstaclesView& obstacles,
                                                          std::int32_t body, double margin,
                                                          ContactSet& out) {
  const BodyView& body_W = obstacles.bodies[static_cast<std::size_t>(body)];
  const SphereTreeView& tree = body_W.tree;
  const Pose X_BG = compose(inverse(body_W.X_WB), X_WG);
  for (std::size_t i = 0; i < tool_.leaf_x.size(); ++i) {
    const auto tool_sphere = static_cast<TreeSphereId>(i);
    const Sphere sphere = tool_.leaf(tool_sphere);
    const Vector3 c = transform(X_BG, sphere.p);
    const __m256d cx = _mm256_set1_pd(c.x()), cy = _mm256_set1_pd(c.y()),
                  cz = _mm256_set1_pd(c.z());
    double radius = std::max(margin, out.minimum_gap) + sphere.r;
    for (std::size_t j = 0; j + 4 <= tree.leaf_x.size(); j += 4) {
      const __m256d dx = _mm256_sub_pd(_mm256_loadu_pd(&tree.leaf_x[j]), cx);
      const __m256d dy = _mm256_sub_pd(_mm256_loadu_pd(&tree.leaf_y[j]), cy);
      const __m256d dz = _mm256_sub_pd(_mm256_loadu_pd(&tree.leaf_z[j]), cz);
      const __m256d square = _mm256_add_pd(
          _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy)), _mm256_mul_pd(dz, dz));
      const __m256d near = _mm256_add_pd(_mm256_loadu_pd(&tree.leaf_r[j]), _mm256_set1_pd(radius));
      auto hits = static_cast<unsigned>(
          _mm256_movemask_pd(_mm256_cmp_pd(square, _mm256_mul_pd(near, near), _CMP_LT_OQ)));
      for (; hits != 0; hits &= hits - 1) {
        const auto body_sphere = static_cast<TreeSphereId>(j) + std::countr_zero(hits);
        add({ObstacleKind::kBody, body, tool_sphere, body_sphere}, X_WG, obstacles, margin, out);
        radius = std::max(margin, out.minimum_gap) + sphere.r;
      }
    }
  }
}

void Avx2BruteForce::find(const Pose& X_WG, const ObstaclesView& obstacles,
                          const QueryOptions& options, ContactSet& out) {
  out.contacts.clear();
  out.minimum_gap = options.horizon;
  out.covered_margin = options.margin;
  for (std::size_t k = 0; k < obstacles.capsules_W.size(); ++k) {
    against_capsule(X_WG, obstacles, static_cast<std::int32_t>(k), options.margin, out);
  }
  for (std::size_t k = 0; k < obstacles.bodies.size(); ++k) {
    against_body(X_WG, obstacles, static_cast<std::int32_t>(k), options.margin, out);
  }
}

}  // namespace hapticd::test
