// A recorded tool led again, sub-step by sub-step: where it comes to must be what was recorded, bit
// for bit, and what it met on its way is judged by exhaustive search (path_judge.h). Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/scene_io/model_files.h"
#include "tests/oracle/scene_objects.h"

namespace hapticd {

/// What a tick has come to. Gaps in m, at most kFarthestGap.
struct JudgedTick {
  std::uint64_t tick = 0;
  double path_gap = kFarthestGap;     ///< smallest on the way
  std::vector<double> gap_of_object;  ///< at the committed pose, in the order of SceneObjects
};

struct PathCheck {
  std::string recording;
  ScenePaths paths;                       ///< of the models
  std::optional<std::uint32_t> scene_id;  ///< whose ticks are judged; none: the first that has any
};

/// Judges the ticks of a scene in a recording from its first on, and calls `begin` before them and
/// `visit` for each. Ticks before the first good pose are passed over. Throws std::runtime_error
/// with file, tick and remedy: when the poses differ, when ticks were lost, when the scene has
/// several tools, or when the recording does not hold the scene's first tick. About 0.5 ms a tick
/// in touch with a large body.
void check_path(const PathCheck& check, const std::function<void(const SceneObjects&)>& begin,
                const std::function<void(const JudgedTick&)>& visit);

}  // namespace hapticd
