// What the commands on scenes share: where scenes and models are, and how problems are reported.
// Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/scene_io/scene_loader.h"

namespace hapticd {

struct SceneOptions {
  std::vector<std::string> scenes;  ///< names or files; none: all that are installed
  std::string data;                 ///< folder with scenes/ and models/; empty: the installed ones
  std::optional<std::uint32_t> quality;  ///< level instead of the scenes' own choice
};

/// Adds SCENE... and --data.
void add_scene_options(CLI::App& command, SceneOptions& options);

/// Adds --quality.
void add_quality_option(CLI::App& command, SceneOptions& options);

/// Loads each of the scenes in turn, prints its problems to stderr and calls `visit` for those that
/// can be played. Throws CLI::RuntimeError(1) at the end when there was a fault, std::runtime_error
/// when there is no scene at all.
void for_each_scene(const SceneOptions& options,
                    const std::function<void(const std::string& name, const LoadedScene&)>& visit);

}  // namespace hapticd
