// See scene_option.h.
#include "server/model/scene_option.h"

#include <cstdio>
#include <stdexcept>

#include "core/scene/quality.h"
#include "server/scene_io/named_text.h"

namespace hapticd {

void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("SCENE", options.scenes,
                     "name of an installed scene, or a .textproto file (default: all installed)");
  command.add_option("--data", options.data,
                     "folder with scenes/ and models/ (default: the installed one)");
  command.add_flag("--json", options.json, "all of it as one JSON object, for programs");
}

void add_quality_option(CLI::App& command, SceneOptions& options) {
  command
      .add_option("--quality", options.quality,
                  "level to explain, 0 to 4, instead of the scene's own choice")
      ->check(CLI::Range(0, kQualityLevels - 1).description(""))
      ->type_name("LEVEL");
}

bool load_each_scene(const SceneOptions& options,
                     const std::function<void(const std::string&, const LoadResult&)>& visit) {
  LoadOptions load;
  const std::filesystem::path data(options.data);
  load.paths =
      options.data.empty() ? installed_paths() : ScenePaths{{data / "scenes"}, {data / "models"}};
  if (options.quality) load.quality.quality.emplace().set_level(*options.quality);
  const std::vector<std::string> scenes =
      options.scenes.empty() ? list_names(load.paths.scenes) : options.scenes;
  if (scenes.empty()) {
    throw std::runtime_error("no scene is installed in " + load.paths.scenes.front().string() +
                             ". Name a file, or the folder with --data");
  }
  bool good = true;
  for (const std::string& scene : scenes) {
    const LoadResult result = load_scene(scene, load);
    good = good && result.loaded != nullptr;
    visit(scene, result);
  }
  return good;
}

void print_problems(const SceneProblems& problems) {
  for (const SceneProblem& problem : problems) {
    std::fprintf(stderr, "%s\n", to_text(problem).c_str());
  }
}

void end_with(bool good) {
  if (!good) throw CLI::RuntimeError(1);
}

}  // namespace hapticd
