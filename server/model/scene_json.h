// What check and explain say of a scene, for programs: numbers with their units in the names.
// Offline.
#pragma once

#include <string>

#include "server/model/printed_json.h"
#include "server/model/tick_cost.h"
#include "server/scene_io/scene_loader.h"

namespace hapticd {

/// Whether the scene can be played, and why not.
[[nodiscard]] Json checked_json(const std::string& name, const LoadResult& result);

/// What explain() says; `cost` of the first tool.
[[nodiscard]] Json explained_json(const std::string& name, const LoadedScene& loaded,
                                  const TickCost& cost);

}  // namespace hapticd
