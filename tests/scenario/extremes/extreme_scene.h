// A scene in which everything is at an end of its range, at every level of quality and with both
// models of a string: what the table of extremes is played in. Frames: W. SI. Not RT.
#pragma once

#include <string>
#include <vector>

#include "core/instrument/string_preset.h"
#include "core/scene/scene.h"

namespace hapticd::test {

/// How a scene is computed.
struct Computation {
  int level = 0;  ///< of quality
  StringPreset preset = StringPreset::kPaper;
  [[nodiscard]] std::string name() const;
};

/// Every level of quality with both models.
[[nodiscard]] std::vector<Computation> all_computations();

/// Radius of the tip that most hands press with, m.
inline constexpr double kTip = 5e-3;
/// Radius of the strings that have one, m.
inline constexpr double kStringRadius = 0.34e-3;
/// Where the usual string lies: along x from 0 to 1.1 at y = 0 and this z.
inline constexpr double kUsualZ = 0.0;

/// A tool with levers in all directions among eight strings (usual, without radius, two nearly
/// parallel and all but at one place, slack, 1 um long, of no length, thick and 20 mm long), a bar
/// whose ends are one point, and a plate of spheres below x = 0.8. The tool begins in the open.
[[nodiscard]] SceneDescription extreme_scene(const Computation& computation);

/// The same tool among the usual string, a bar across and a pillar: what a contact switches
/// between.
[[nodiscard]] SceneDescription switching_scene(const Computation& computation);

/// One tip over one usual string, `spheres` times at the same place.
[[nodiscard]] SceneDescription crowded_scene(const Computation& computation, int spheres);

}  // namespace hapticd::test
