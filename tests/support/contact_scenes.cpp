// See contact_scenes.h.
#include "tests/support/contact_scenes.h"

#include <cmath>

namespace hapticd::test {

std::vector<Sphere> random_cluster(SplitMix64& random, int count, double half_width, double r_min,
                                   double r_max) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < count; ++i) {
    const Vector3 p = random_vector(random, half_width);
    spheres.push_back({p, random.uniform(r_min, r_max)});
  }
  return spheres;
}

std::vector<Sphere> hand_spheres() {
  std::vector<Sphere> spheres;
  // Palm: 11 spheres in rows of 4, 4 and 3.
  for (int i = 0; i < 11; ++i) {
    const int row = i / 4;
    const double x = -0.030 + 0.020 * (i % 4);
    spheres.push_back({{x, 0.0, 0.040 - 0.025 * row}, 0.014});
  }
  // Five fingers of 5 spheres from knuckle to tip, bent downwards; the first is the thumb.
  constexpr double kRoot[5][2] = {
      {-0.050, 0.020}, {-0.033, -0.025}, {-0.011, -0.032}, {0.011, -0.030}, {0.033, -0.022}};
  constexpr double kPhalanx[5] = {0.012, 0.018, 0.020, 0.019, 0.015};
  for (int finger = 0; finger < 5; ++finger) {
    for (int joint = 0; joint < 5; ++joint) {
      const double s = kPhalanx[finger] * (joint + 1);
      const double sideways = finger == 0 ? -0.5 * s : 0.0;
      const double down = 0.6 * kPhalanx[finger] * (joint * joint) / 4.0;
      spheres.push_back(
          {{kRoot[finger][0] + sideways, -down, kRoot[finger][1] - s}, 0.009 - 0.001 * joint});
    }
  }
  return spheres;
}

std::vector<Sphere> blob_spheres(int count) {
  // Directions on a spiral that turns by the golden angle from one to the next.
  constexpr double kCosine = -0.73736887807831985, kSine = 0.67549029426152370;
  // Leaf radius about 1.4 spacings of a 0.028 m^2 surface.
  const double r = 1.4 * std::sqrt(0.028 / count);
  std::vector<Sphere> spheres;
  double c = 1.0;
  double s = 0.0;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count;
    const double ring = std::sqrt(1.0 - z * z);
    const Vector3 d{ring * c, ring * s, z};
    const double lump = 1.0 + 0.12 * d.x() * d.y() + 0.10 * d.z() * d.z() * d.x() - 0.08 * d.y();
    spheres.push_back({{0.055 * lump * d.x() - r * d.x(), 0.045 * lump * d.y() - r * d.y(),
                        0.040 * lump * d.z() - r * d.z()},
                       r});
    const double next = c * kCosine - s * kSine;
    s = c * kSine + s * kCosine;
    c = next;
  }
  return spheres;
}

std::vector<Sphere> slab_spheres(int along, int across) {
  constexpr double kRadius = 0.010;
  std::vector<Sphere> spheres;
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across; ++j) {
      const double x = -0.6 + 1.2 * (i + 0.5) / along;
      const double v = -1.0 + 2.0 * (j + 0.5) / across;
      spheres.push_back({{x, -kRadius - 0.020 * v * v, 0.1 * v}, kRadius});
    }
  }
  return spheres;
}

std::vector<Capsule> seven_strings() {
  std::vector<Capsule> strings;
  for (int k = 0; k < 7; ++k) {
    const double z = -0.06 + 0.02 * k;
    strings.push_back({{-0.55, 0.015, z}, {0.55, 0.015, z}, 0.34e-3});
  }
  return strings;
}

Quaternion random_rotation(SplitMix64& random) {
  // Uniform in the unit ball of four dimensions, projected to its surface.
  for (;;) {
    const double w = random.uniform(-1.0, 1.0);
    const double x = random.uniform(-1.0, 1.0);
    const double y = random.uniform(-1.0, 1.0);
    const double z = random.uniform(-1.0, 1.0);
    const double square = (w * w + x * x) + (y * y + z * z);
    if (square < 1e-3 || square > 1.0) continue;
    const double norm = std::sqrt(square);
    return {w / norm, x / norm, y / norm, z / norm};
  }
}

Directions random_directions(SplitMix64& random) {
  const Quaternion q = random_rotation(random);
  return {q * Vector3(1, 0, 0), q * Vector3(0, 1, 0)};
}

Vector3 random_vector(SplitMix64& random, double half_width) {
  const double x = random.uniform(-half_width, half_width);
  const double y = random.uniform(-half_width, half_width);
  const double z = random.uniform(-half_width, half_width);
  return {x, y, z};
}

}  // namespace hapticd::test
