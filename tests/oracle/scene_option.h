// What the commands share: the scene they look at and the tool they lead, from the command line.
// Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "server/scene_io/scene_loader.h"

namespace hapticd {

struct SceneOption {
  std::string scene;   ///< name or file
  std::string preset;  ///< "paper", "deflecting", or "" for the scene's own
  std::string data;    ///< folder with scenes/, models/ and gestures/; empty: the installed one
  std::optional<std::uint32_t> tool_id;  ///< none: the scene's first tool
};

/// Adds --scene (needed where `required`), --preset, --tool and --data.
void add_scene_options(CLI::App& command, SceneOption& option, bool required);

/// Adds --data alone.
void add_data_option(CLI::App& command, std::string& data);

/// Where scenes and models are.
[[nodiscard]] ScenePaths scene_paths(const std::string& data);

/// Loads the scene; prints problems to stderr and throws CLI::RuntimeError(1) when it cannot be
/// played.
[[nodiscard]] std::unique_ptr<LoadedScene> load_scene(const SceneOption& option);

/// Index of the chosen tool in the scene. Throws std::invalid_argument.
[[nodiscard]] std::size_t chosen_tool(const SceneOption& option, const SceneDescription& scene);

}  // namespace hapticd
