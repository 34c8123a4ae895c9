// The same hand for a tick and for the grid of tests/truth: a path along straight lines, and the
// force that each makes of it, tick by tick.
#pragma once

#include <vector>

#include "tests/core/simulation/wave_scene.h"
#include "tests/truth/played_string.h"

namespace hapticd::test {

/// Length of the strings of Instrument, m.
inline constexpr double kWaveLength = 1.1;

/// Where a hand goes, from point to point.
class HandPath {
 public:
  explicit HandPath(const FingerPlace& start) : points_{{0.0, start}} {}
  /// Goes on to `place` at `speed` (m/s).
  HandPath& go(const FingerPlace& place, double speed);
  /// Stays for `seconds`.
  HandPath& stay(double seconds);
  [[nodiscard]] double end() const { return points_.back().time; }
  [[nodiscard]] FingerPlace at(double time) const;

 private:
  struct Point {
    double time;
    FingerPlace place;
  };
  std::vector<Point> points_;
};

/// `place` in the world of Instrument.
[[nodiscard]] Vector3 in_world(const FingerPlace& place);

/// What a hand felt in each tick, across the string, N.
struct FeltForces {
  std::vector<Across> all;
  std::vector<Across> law;     ///< of that the static law
  std::vector<double> energy;  ///< of the ringing, or of the string, J
};

/// Plays `path` by ticks of 1 ms.
[[nodiscard]] FeltForces feel(Instrument& instrument, const HandPath& path);

/// The grid's string of a scene.
[[nodiscard]] GridString grid_of(const WaveScene& scene);

/// The same path on the grid: means of each millisecond; `law` stays empty.
[[nodiscard]] FeltForces feel(const WaveScene& scene, const HandPath& path, int cells);

}  // namespace hapticd::test
