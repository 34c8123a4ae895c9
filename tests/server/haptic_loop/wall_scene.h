// A scene for whoever needs one thing to press against.
#pragma once

namespace hapticd::test {

/// A finger 25 mm above a wall, which is flat to what a finger can tell.
inline constexpr const char* kWallScene = R"(
name: "wall"
tools {
  name: "finger"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0, 0.025] }
}
bodies { name: "wall" shape { spheres { centre_m: [0, 0, -1000] radius_m: 1000 } } }
)";

}  // namespace hapticd::test
