// Axis maps against pictures drawn by hand: where a raw direction points in D.
#include "device/api/axis_mapping.h"

#include <doctest/doctest.h>

namespace hapticd::test {
namespace {

/// Raw x right, y toward the user, z down: right-handed.
AxisMapping z_down() {
  AxisMapping map;
  map.raw_axis = {0, 2, 1};
  map.sign = {1.0, -1.0, 1.0};
  map.position_scale = {2.0, 3.0, 4.0};
  map.rotation_scale = {5.0, 6.0, 7.0};
  map.force_scale = {0.5, 0.25, 0.125};
  return map;
}

}  // namespace

TEST_CASE("each axis of D takes its raw axis, sign and scale") {
  const AxisMapping map = z_down();
  CHECK(position_in_base(map, {1.0, 0.0, 0.0}) == Array3{2.0, 0.0, 0.0});
  CHECK(position_in_base(map, {0.0, 1.0, 0.0}) == Array3{0.0, 0.0, 4.0});
  CHECK(position_in_base(map, {0.0, 0.0, 1.0}) == Array3{0.0, -3.0, 0.0});
}

TEST_CASE(
    "rotations follow their axis where the axes are right-handed, and are mirrored where not") {
  AxisMapping map = z_down();
  CHECK(handedness(map) == 1.0);
  CHECK(rotation_in_base(map, {0.0, 0.0, 1.0}) == Array3{0.0, -6.0, 0.0});
  // x mirrored alone: turning about x stays as it is, about the others it is reversed.
  AxisMapping mirror;
  mirror.sign[0] = -1.0;
  CHECK(handedness(mirror) == -1.0);
  CHECK(rotation_in_base(mirror, {1.0, 2.0, 3.0}) == Array3{1.0, -2.0, -3.0});
  AxisMapping cyclic;
  cyclic.raw_axis = {1, 2, 0};
  CHECK(handedness(cyclic) == 1.0);
}

TEST_CASE("a force goes back the way positions came, in units of the device") {
  AxisMapping map = z_down();
  CHECK(raw_force(map, {1.0, 0.0, 0.0}) == Array3{2.0, 0.0, 0.0});
  CHECK(raw_force(map, {0.0, 1.0, 0.0}) == Array3{0.0, 0.0, -4.0});
  CHECK(raw_force(map, {0.0, 0.0, 1.0}) == Array3{0.0, 8.0, 0.0});
  map.force_sign = {-1.0, 1.0, 1.0};
  CHECK(raw_force(map, {1.0, 0.0, 0.0}) == Array3{-2.0, 0.0, 0.0});
}

}  // namespace hapticd::test
