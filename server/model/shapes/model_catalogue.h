// The models that come with hapticd, by name, with parameters that can be set by name: what
// hapticd-model makes meshes and trees from. All are closed, oriented outwards and in m. Offline.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/model/packing/triangle_mesh.h"
#include "server/model/shapes/parameter_field.h"

namespace hapticd {

/// Name of a parameter and the value it is to have, SI.
using ParameterValue = std::pair<std::string, double>;

/// A parameter of a model.
struct ModelParameter {
  ModelRange range;
  double value;  ///< default
};

struct NamedModel {
  std::string_view name;
  std::string_view description;
  /// Number of separate solids in the mesh; they do not overlap.
  int solids;
  std::vector<ModelParameter> (*parameters)();
  /// Later values of the same name win. Throws std::invalid_argument naming the model, the
  /// parameter and its range, or the names there are.
  TriangleMesh (*make)(std::span<const ParameterValue> values);
};

/// All models, in a fixed order; names are unique.
[[nodiscard]] std::span<const NamedModel> model_catalogue();

/// nullptr when there is no model of that name.
[[nodiscard]] const NamedModel* find_model(std::string_view name);

}  // namespace hapticd
