// A string over frets or a board, and fingers that play it.
#pragma once

#include <memory>
#include <vector>

#include "core/scene/scene.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {

/// Radius of the fingers, m.
inline constexpr double kFretFinger = 5e-3;

/// Top of a fret: where it is along x, and below the axis of the string, m.
struct FretTop {
  double x = 0.0;
  double below = 3e-3;
};

struct FrettedOptions {
  double length = 0.648;  ///< m: from A at x = 0 along x
  double tension = 70.0;  ///< N
  double frequency = 110.0;
  double axial_stiffness = 5e3;  ///< N
  double friction = 0.0;         ///< between finger and string; 0: off
  std::vector<FretTop> frets;
  double board_below = 0.0;  ///< a flat board so far below the string, m; 0: none
  bool sounds = false;
  std::size_t fingers = 1;
};

/// Plays it with the hands at `p_WH`, a tick of 1 ms each.
class FrettedString {
 public:
  explicit FrettedString(const FrettedOptions& options);

  const SimulationTick& tick(const std::vector<Vector3>& p_WH);
  /// Of finger `finger` after the last tick, N.
  [[nodiscard]] Vector3 force(std::size_t finger = 0) const;
  [[nodiscard]] bool recovers(std::size_t finger = 0) const;
  /// How far the string as it is bent passes below the frets, m; <= 0: above them.
  [[nodiscard]] double sunk() const;
  [[nodiscard]] Simulation& simulation() { return *play_.simulation; }
  /// Of finger 0 where it touches the string at rest, m.
  [[nodiscard]] double reach() const;

 private:
  FrettedOptions options_;
  std::unique_ptr<Scene> scene_;
  OwnedSimulation play_;
  SimulationTick output_;
  std::int64_t t_ns_ = 0;
};

/// The scene that it is played in.
[[nodiscard]] SceneDescription fretted_scene(const FrettedOptions& options);

/// Least force with which a spring of `kt` (N/m) whose end is `depth` (m) below the string at rest
/// presses it at x, over the frets, N: the shortest way by a convex hull, the depth of least energy
/// by bisection. The finger has no size.
[[nodiscard]] double pressed_force(const FrettedOptions& options, double x, double depth,
                                   double kt);

/// Length of the way from A over the frets, and through (x, -down), to B, m.
[[nodiscard]] double way_over(const FrettedOptions& options, double x, double down);

}  // namespace hapticd::test
