// What a scene models and what it does not, in words and numbers that explain prints and gives as
// JSON. Offline.
#pragma once

#include <string>
#include <vector>

#include "core/scene/quality.h"
#include "core/scene/scene_description.h"

namespace hapticd {

inline constexpr double kRadianInDegrees = 57.29577951308232;

/// A line each, of what is modelled; some have line breaks with four blanks behind them.
[[nodiscard]] std::vector<std::string> modelled(const SceneDescription& scene);
/// What is not.
[[nodiscard]] std::vector<std::string> not_modelled(const SceneDescription& scene);

/// What follows the live tension_n of a string.
[[nodiscard]] const char* string_tuning(const StringParameters& string);

/// The spheres of a shape that contact is computed with.
struct PlayedShape {
  std::size_t spheres = 0;
  int level = 0;       ///< of the tree, from 1, the coarsest; 0: its leaves
  double outer = 0.0;  ///< bound of theirs outside the mesh, m
};

/// At `level` as shown_level() has it.
[[nodiscard]] PlayedShape played_shape(const ShapeDescription& shape, int level);

/// Level of the trees, from 1; 0 for their leaves.
[[nodiscard]] int shown_level(int level) noexcept;

/// Whether `options` are those that `quality` was measured with.
[[nodiscard]] bool is_as_measured(const ContactOptions& options, const Quality& quality) noexcept;

}  // namespace hapticd
