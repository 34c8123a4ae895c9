// What a string costs on each rung of its ladder (core/README.md), in instructions of a tick: the
// same on a busy machine. Counted by tests/one_string/string_costs, which also holds it true. Of
// other modes N and sub-steps S than were counted: pressed a + S (b + c N), with the three numbers
// of those that were; ringing a line through N alone, for a wave that nothing touches is turned in
// closed form. Offline.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/scene/scene_description.h"

namespace hapticd {

/// Where on the ladder a string is played, and how.
struct StringRung {
  StringDetail level = StringDetail::kLine;
  bool stretches = false;  ///< of kModes: its tension follows how it is bent
  int modes = 0;           ///< of kModes: that it has
  int substeps = 0;        ///< of kModes: of a millisecond

  bool operator==(const StringRung&) const = default;
};

/// As explain names it.
[[nodiscard]] std::string rung_name(const StringRung& rung);

/// What one string adds to a tick, instructions.
struct StringCost {
  double silent = 0.0;   ///< nobody is near
  double ringing = 0.0;  ///< and nobody is near; below 0: it does not ring
  double pressed = 0.0;  ///< by one finger
};

/// The rung that a string climbs to in a scene with `options`.
[[nodiscard]] StringRung rung_of(const StringParameters& string, const InstrumentOptions& options);

/// How many strings of a scene are on which rung. Of waves the count of modes is the largest.
[[nodiscard]] std::vector<std::pair<StringRung, int>> rungs_of(const SceneDescription& scene);

/// What a string on `rung` costs.
[[nodiscard]] StringCost string_cost(const StringRung& rung);

/// The table of all rungs, and a line for each kind of string in `scene`; empty where it has none.
[[nodiscard]] std::string string_costs(const SceneDescription& scene);

}  // namespace hapticd
