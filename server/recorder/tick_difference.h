// Where a replayed tick differs from the recorded one. Not RT.
#pragma once

#include <string>

#include "core/tick/tick.h"

namespace hapticd {

/// What of two ticks is compared.
enum class Compared : std::uint8_t {
  kAll,
  kPoses,  ///< of the hands alone: the recording is of other physics
};

/// The first of what the tick gave that differs in any bit, such as "wrench_h_w of tool 0": names
/// are those of TickRecord. Empty: all is the same. Time spent is not compared. 100 ns.
[[nodiscard]] std::string tick_difference(const Tick& recorded, const Tick& replayed,
                                          Compared compared = Compared::kAll);

}  // namespace hapticd
