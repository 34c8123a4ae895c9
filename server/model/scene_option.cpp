// See scene_option.h.
#include "server/model/scene_option.h"

#include <cstdio>
#include <stdexcept>

namespace hapticd {

void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("SCENE", options.scenes,
                     "name of an installed scene, or a .textproto file (default: all installed)");
  command.add_option("--data", options.data,
                     "folder with scenes/ and models/ (default: the installed one)");
}

void for_each_scene(const SceneOptions& options,
                    const std::function<void(const std::string&, const LoadedScene&)>& visit) {
  LoadOptions load;
  const std::filesystem::path data(options.data);
  load.paths =
      options.data.empty() ? installed_paths() : ScenePaths{{data / "scenes"}, {data / "models"}};
  const std::vector<std::string> scenes =
      options.scenes.empty() ? list_scenes(load.paths) : options.scenes;
  if (scenes.empty()) {
    throw std::runtime_error("no scene is installed in " + load.paths.scenes.front().string() +
                             ". Name a file, or the folder with --data");
  }
  bool faulty = false;
  for (const std::string& scene : scenes) {
    const LoadResult result = load_scene(scene, load);
    for (const SceneProblem& problem : result.problems) {
      std::fprintf(stderr, "%s\n", to_text(problem).c_str());
    }
    faulty = faulty || result.loaded == nullptr;
    if (result.loaded != nullptr) visit(scene, *result.loaded);
  }
  if (faulty) throw CLI::RuntimeError(1);
}

}  // namespace hapticd
