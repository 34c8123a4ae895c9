// What a tool met on its way, by exhaustive search (contact_oracle.h) over all pairs of spheres and
// capsules that its motion could have brought together: the smallest gap along the committed path
// of a tick, and the gap to each obstacle where it ends. Soft parts and bent strings move as the
// contact problem says. Frames: W. SI. Not RT.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/simulation/tool_renderer.h"
#include "tests/truth/contact_oracle.h"
#include "tests/truth/sphere_grid.h"
#include "tests/truth/sphere_groups.h"

namespace hapticd {

/// Gaps beyond this are not distinguished, m.
inline constexpr double kFarthestGap = 1e-3;

/// Gaps at a pose, in the order of the obstacles, at most kFarthestGap.
struct ObstacleGaps {
  std::vector<double> capsules;
  std::vector<double> bodies;
};

class PathJudge {
 public:
  /// `scene`'s tool, obstacles and parts are looked at, now and later.
  explicit PathJudge(const ToolScene& scene);

  /// Smallest gap on the way along `path`, whose states follow each other along screw motions; at
  /// most kFarthestGap. One that is greater than 0 may be that of an end of the way: what cannot
  /// touch any more is not followed.
  [[nodiscard]] double smallest_gap(std::span<const ContactState> path);

  /// Gaps of the tool in one state to every obstacle.
  [[nodiscard]] ObstacleGaps gaps(const ContactState& state);

  /// Number of tool spheres.
  [[nodiscard]] std::size_t tool_spheres() const noexcept { return tool_spheres_.size(); }

 private:
  /// What could meet on the way of a tick.
  struct Vicinity {
    std::vector<std::size_t> tool;  ///< spheres of the tool
    std::vector<Capsule> straight;
    std::vector<std::size_t> held;            ///< capsules that are strings held on the way
    std::vector<std::vector<Sphere>> bodies;  ///< spheres of each, in W
  };
  [[nodiscard]] Vicinity vicinity(std::span<const ContactState> path);
  /// The tool's spheres in G, and where they are together.
  struct Displaced {
    std::vector<Sphere> spheres;
    std::vector<SphereGroup> groups;
  };
  [[nodiscard]] Displaced displaced_spheres(const ContactState& state) const;
  /// Of the whole group at once, whose ball is in W: none of its spheres meets anything.
  [[nodiscard]] bool meets_nothing(const Vicinity& near, const Sphere& ball_W, double far,
                                   double bent) const;
  [[nodiscard]] double gap_to_body(std::size_t body, const Displaced& tool_G,
                                   const Pose& X_WG) const;
  [[nodiscard]] double gap_to_capsule(std::span<const Capsule> legs, const Displaced& tool_G,
                                      const Pose& X_WG) const;
  /// Bound of the distance of any point of the tool from G, m.
  [[nodiscard]] double reach(const ContactState& state) const;

  std::span<const Capsule> capsules_;
  ToolParts parts_;
  std::vector<Sphere> tool_spheres_;  ///< in G
  std::vector<SphereGroup> tool_groups_;
  double rigid_reach_ = 0.0;
  std::vector<std::unique_ptr<SphereGrid>> bodies_;  ///< in W
  std::vector<double> blends_;                       ///< widths, m; 0: the body has none
  /// Per body and sphere, the last look that has found it near.
  std::vector<std::vector<std::uint64_t>> seen_;
  std::uint64_t looks_ = 0;
  /// Places at which gaps are taken lie at most so far apart, m.
  long double spacing_ = 0.0L;
};

}  // namespace hapticd
