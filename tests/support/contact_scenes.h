// The tools and obstacles that tests and benchmarks of the contact core share: sphere clusters, a
// hand, a blob of the size of the bunny, a Guqin-like body, seven strings. Deterministic: no libm
// but sqrt. Lengths in m; strings and body in W (x along the strings, y up, z across). Not RT.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/capsule.h"
#include "core/geometry/sphere.h"
#include "core/math/pose.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// `count` spheres with centres uniform in a cube of half-width `half_width` and radii uniform in
/// [r_min, r_max].
[[nodiscard]] std::vector<Sphere> random_cluster(SplitMix64& random, int count, double half_width,
                                                 double r_min, double r_max);

/// An open hand of 36 spheres, fingers along -z, palm around the origin, facing down; about 180 mm
/// long, fingertips of 5 mm radius.
[[nodiscard]] std::vector<Sphere> hand_spheres();

/// `count` spheres on a lumpy egg 110 x 90 x 80 mm around the origin; radii shrink with the
/// spacing. 1000 of them are the "bunny" of the benchmarks.
[[nodiscard]] std::vector<Sphere> blob_spheres(int count);

/// `along` x `across` spheres of radius 10 mm that carry a Guqin's top: 1.2 m along x, 0.2 m along
/// z, arched 20 mm, its crown at y = 0. 160 x 25 and 250 x 40 are the bodies of the benchmarks.
[[nodiscard]] std::vector<Sphere> slab_spheres(int along, int across);

/// Seven strings of 1.1 m, radius 0.34 mm, 20 mm apart, 15 mm above the crown of the slab.
[[nodiscard]] std::vector<Capsule> seven_strings();

/// A rotation uniform over all rotations.
[[nodiscard]] Quaternion random_rotation(SplitMix64& random);

/// A unit vector and one normal to it.
struct Directions {
  Vector3 along;
  Vector3 across;
};

/// Directions uniform over all rotations.
[[nodiscard]] Directions random_directions(SplitMix64& random);

/// A vector uniform in the cube of half-width `half_width`.
[[nodiscard]] Vector3 random_vector(SplitMix64& random, double half_width);

}  // namespace hapticd::test
