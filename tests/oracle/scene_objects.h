// The objects of a scene by name: strings, then lines, then bodies, and which of them the
// contact problem's obstacles are pieces of. Not RT.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "tests/truth/path_judge.h"

namespace hapticd {

struct SceneObjects {
  std::vector<std::string> names;
  std::vector<std::size_t> of_capsule;  ///< object that a capsule is a piece of
  std::vector<std::size_t> of_body;
};

[[nodiscard]] SceneObjects scene_objects(const Scene& scene);

/// Smallest gap to each object, m.
[[nodiscard]] std::vector<double> object_gaps(const SceneObjects& objects,
                                              const ObstacleGaps& gaps);

/// "gap_of_NAME_m" of each object: names of the columns.
[[nodiscard]] std::vector<std::string> gap_columns(const SceneObjects& objects);

}  // namespace hapticd
