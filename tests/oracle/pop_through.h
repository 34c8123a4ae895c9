// Pop-through, defined: a tool sphere and the axis of a string or line overlap (the sphere's centre
// C is nearer to the axis AB than s = r_tool + R) from one place of the tool's path to a later one;
// the sphere has popped through when, between them,
//   it leaves on another side than it came from, n_in . n_out < 0 (n: unit vector from the nearest
//   point of AB to C, where the overlap begins and where it ends), and
//   it did not go around: C came nearer to AB than s / sqrt 2.
// A sphere that slips round a string, pressed on it, keeps C at about s all the way; one that is
// led straight through comes as near as s cos(phi / 2), phi > 90 degrees the angle from n_in to
// n_out. So neither a graze nor the slip that plucks a string counts. The radius is the true R,
// whatever a method collides with, and the path is the committed one: from pose to pose along the
// screw between them, in steps of s / 16. Frame W. SI. Not RT.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/simulation/tool_renderer.h"
#include "tests/truth/sphere_groups.h"

namespace hapticd {

class PopThroughWatch {
 public:
  /// `scene`'s tool and capsules are looked at, now and later.
  explicit PopThroughWatch(const ToolScene& scene);

  /// The tool goes from X_WF to X_WT. Per capsule: true where a sphere of the tool has just popped
  /// through.
  [[nodiscard]] std::vector<bool> go(const Pose& X_WF, const Pose& X_WT);

 private:
  /// An overlap under way.
  struct Overlap {
    Vector3 nhat_in_W{0.0, 0.0, 0.0};
    double nearest = 0.0;  ///< of C to AB so far, m
  };
  [[nodiscard]] bool follow_sphere(std::size_t capsule, std::size_t sphere,
                                   std::span<const Pose> path);

  std::span<const Capsule> capsules_;
  std::vector<Sphere> tool_spheres_;
  std::vector<SphereGroup> tool_groups_;                             ///< of these
  double reach_ = 0.0;                                               ///< m
  double thinnest_ = 0.0;                                            ///< smallest s, m
  std::map<std::pair<std::size_t, std::size_t>, Overlap> overlaps_;  ///< by capsule and sphere
};

}  // namespace hapticd
