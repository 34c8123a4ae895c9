// See scene_option.h.
#include "tests/oracle/scene_option.h"

#include <cstdio>
#include <map>
#include <stdexcept>

namespace hapticd {
namespace {

const std::map<std::string, v1::Preset> kPresets{{"paper", v1::PRESET_PAPER},
                                                 {"deflecting", v1::PRESET_DEFLECTING}};

}  // namespace

void add_data_option(CLI::App& command, std::string& data) {
  command
      .add_option("--data", data,
                  "folder with scenes/, models/ and gestures/ (default: the installed one)")
      ->type_name("DIR");
}

void add_scene_options(CLI::App& command, SceneOption& option, bool required) {
  command.add_option("--scene", option.scene, "name of an installed scene, or a .textproto file")
      ->type_name("NAME|FILE")
      ->required(required);
  command.add_option("--preset", option.preset, "model of the strings (default: the scene's own)")
      ->check(CLI::Validator(CLI::IsMember(kPresets)).description(""))
      ->type_name("paper|deflecting");
  command.add_option("--tool", option.tool_id, "tool_id (default: the scene's first tool)")
      ->type_name("ID");
  add_data_option(command, option.data);
}

ScenePaths scene_paths(const std::string& data) {
  if (data.empty()) return installed_paths();
  const std::filesystem::path folder(data);
  return {{folder / "scenes"}, {folder / "models"}};
}

std::unique_ptr<LoadedScene> load_scene(const SceneOption& option) {
  LoadOptions load;
  load.paths = scene_paths(option.data);
  if (!option.preset.empty()) load.preset = kPresets.at(option.preset);
  LoadResult result = load_scene(option.scene, load);
  for (const SceneProblem& problem : result.problems) {
    std::fprintf(stderr, "%s\n", to_text(problem).c_str());
  }
  if (result.loaded == nullptr) throw CLI::RuntimeError(1);
  return std::move(result.loaded);
}

std::size_t chosen_tool(const SceneOption& option, const SceneDescription& scene) {
  if (!option.tool_id) return 0;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    if (scene.tools[k].tool_id == *option.tool_id) return k;
  }
  std::string known;
  for (const ToolDescription& tool : scene.tools) known += " " + std::to_string(tool.tool_id);
  throw std::invalid_argument("--tool: the scene " + scene.name + " has no tool " +
                              std::to_string(*option.tool_id) + ". Choose one of:" + known);
}

}  // namespace hapticd
