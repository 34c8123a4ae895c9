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
  bool json = false;                     ///< what is printed is for programs
};

/// Adds SCENE..., --data and --json.
void add_scene_options(CLI::App& command, SceneOptions& options);

/// Adds --quality.
void add_quality_option(CLI::App& command, SceneOptions& options);

/// Loads each of the scenes in turn and calls `visit`. True when all can be played. Throws
/// std::runtime_error when there is no scene at all.
[[nodiscard]] bool load_each_scene(
    const SceneOptions& options,
    const std::function<void(const std::string& name, const LoadResult&)>& visit);

/// A line each, to stderr.
void print_problems(const SceneProblems& problems);

/// Ends a command, when all has been said, with the exit code of input that is bad unless `good`:
/// throws CLI::RuntimeError(1).
void end_with(bool good);

}  // namespace hapticd
