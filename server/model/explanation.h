// What of a scene is modelled, what is not, and how far each simplification may be off: for people
// who choose between speed and accuracy. Offline.
#pragma once

#include <string>

#include "server/model/tick_cost.h"
#include "server/scene_io/scene_loader.h"

namespace hapticd {

/// Plain text of some dozen lines; `cost` of the first tool, measured here.
[[nodiscard]] std::string explain(const LoadedScene& loaded, const TickCost& cost);

}  // namespace hapticd
