// Which spheres of a tool overlap what, at one pose: the detection of the methods we compare with.
// Every pair is looked at, except what a grid leaves out. Frame W. SI. Not RT.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/collision/contact.h"
#include "core/simulation/tool_renderer.h"
#include "tests/truth/sphere_grid.h"
#include "tests/truth/sphere_groups.h"

namespace hapticd {

/// A tool sphere that overlaps an obstacle.
struct OverlappingPair {
  ObstacleKind kind = ObstacleKind::kCapsule;
  std::size_t obstacle = 0;  ///< among the capsules, or the bodies
  std::size_t tool_sphere = 0;
  std::size_t body_sphere = 0;
  double lambda = 0.0;  ///< along the capsule's axis
  double radii = 0.0;   ///< of both together, m
  double depth = 0.0;   ///< m, >= 0
};

/// How a string or line ends.
struct CapsuleEnds {
  /// True: flat, as Eq. 1-4: the distance to the line through A and B counts, where lambda is in
  /// [-margin, 1 + margin]. False: round.
  bool flat = false;
  double margin = 0.0;
};

class PairSearch {
 public:
  /// `scene`'s tool and obstacles are looked at, now and later.
  explicit PairSearch(const ToolScene& scene);

  /// Pairs of the tool at X with depth >= 0, in the order of tool spheres; growth[k] is added to
  /// the radius of capsule k.
  [[nodiscard]] std::vector<OverlappingPair> find(const Pose& X, const CapsuleEnds& ends,
                                                  std::span<const double> growth);

  [[nodiscard]] const Sphere& tool_sphere(std::size_t i) const { return tool_spheres_[i]; }
  /// A sphere of a body, in W.
  [[nodiscard]] const Sphere& body_sphere(std::size_t body, std::size_t i) const {
    return bodies_[body]->spheres()[i];
  }
  [[nodiscard]] const Capsule& capsule(std::size_t i) const { return capsules_[i]; }
  [[nodiscard]] std::size_t capsules() const noexcept { return capsules_.size(); }

 private:
  std::span<const Capsule> capsules_;
  std::vector<Sphere> tool_spheres_;                 ///< in G
  std::vector<SphereGroup> tool_groups_;             ///< of these
  std::vector<std::unique_ptr<SphereGrid>> bodies_;  ///< in W
};

/// From the axis of `capsule` to `p`: from the line through A and B where `flat`, else from the
/// nearest point of the segment; and lambda, not clamped where flat.
struct AxisOffset {
  Vector3 offset_W{0.0, 0.0, 0.0};
  double lambda = 0.0;
};
[[nodiscard]] AxisOffset axis_offset(const Capsule& capsule, const Vector3& p_W, bool flat);

}  // namespace hapticd
