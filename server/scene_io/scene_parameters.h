// The live parameters of a scene: fields whose comment says Live, by their paths below Scene. Read
// and written by reflection, checked against the same comments as scene files. Offline.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/scene.pb.h"

namespace hapticd {

/// The live parameters `scene` has, each kind once, [*] for every index; with unit and range.
[[nodiscard]] std::vector<v1::ParameterInfo> live_parameters(const v1::Scene& scene);

struct ParameterReading {
  std::vector<v1::Assignment> values;  ///< in the order of the fields
  std::optional<std::string> unknown;  ///< the first path nothing answers to
};

/// Values of the live parameters of `scene` that `paths` name, [*] standing for every index; of all
/// when there are no paths. `scene` has its defaults filled in.
[[nodiscard]] ParameterReading parameter_values(const v1::Scene& scene,
                                                const std::vector<std::string>& paths);

/// Why `path` names no live parameter of `scene`, for people: which one may have been meant.
[[nodiscard]] std::string unknown_parameter(const v1::Scene& scene, const std::string& path);

}  // namespace hapticd
