// One tool of a scene, led tick by tick and judged along its whole committed path, by exhaustive
// search over all pairs of spheres and capsules that its motion could bring together. Not RT.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "tests/support/contact_oracle.h"

namespace hapticd::test {

class PathRun {
 public:
  /// The tool begins where the scene says. `scene` must outlive this.
  explicit PathRun(const Scene& scene, std::size_t tool = 0);

  /// One tick of 1 ms towards X_WH, not judged.
  void tick(const Pose& X_WH);
  /// The same, and returns the smallest gap on the way, m; 1 when nothing is near.
  long double judged_tick(const Pose& X_WH);

  [[nodiscard]] const Pose& X_WG() const noexcept { return state_.X_WG; }
  [[nodiscard]] const OptimiserResult& result() const noexcept { return result_; }
  /// Names of all objects that have carried force so far.
  [[nodiscard]] const std::set<std::string>& touched() const noexcept { return touched_; }

 private:
  /// What could meet on the way of a tick.
  struct Vicinity {
    std::vector<std::size_t> tool;  ///< spheres of the tool
    std::vector<Capsule> straight;
    std::vector<std::size_t> held;  ///< capsules that are strings held on the way
    std::vector<Sphere> bodies;     ///< in W
  };
  [[nodiscard]] Vicinity vicinity(const std::vector<OptimiserState>& path) const;
  [[nodiscard]] std::vector<Sphere> displaced_spheres(const OptimiserState& state) const;
  [[nodiscard]] long double judge(const std::vector<OptimiserState>& path) const;
  void note_touched();

  const Scene& scene_;
  std::size_t tool_;
  OptimiserState state_;
  OptimiserResult result_;
  std::unique_ptr<OptimiserWorkspace> workspace_ = std::make_unique<OptimiserWorkspace>();
  std::vector<Sphere> tool_spheres_;
  std::vector<Sphere> body_spheres_W_;  ///< of all bodies
  /// Places at which gaps are taken lie at most so far apart, m.
  long double spacing_ = 0.0L;
  std::set<std::string> touched_;
};

}  // namespace hapticd::test
