// See scene_loader.h.
#include "server/scene_io/scene_loader.h"

#include <algorithm>
#include <new>
#include <set>
#include <stdexcept>
#include <system_error>

#include "core/scene/scene_check.h"
#include "server/scene_io/field_check.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/scene_text.h"
#include "server/scene_io/scene_translation.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".textproto";

/// A text and where its models may be.
struct Source {
  std::string_view text;
  std::string file;
  std::vector<fs::path> models;
};

ContentHash hash_of(std::string_view text, const std::vector<SceneAsset>& assets) {
  std::vector<std::uint8_t> bytes(text.begin(), text.end());
  for (const SceneAsset& asset : assets) {
    bytes.insert(bytes.end(), asset.hash.begin(), asset.hash.end());
  }
  return content_hash(bytes);
}

LoadResult load(const Source& source, const LoadOptions& options) {
  LoadResult result;
  const SceneText text(source.text, source.file);
  result.problems = text.problems();
  if (any_fault(result.problems)) return result;
  const auto add = [&](SceneProblem problem) {
    result.problems.push_back(text.located(std::move(problem)));
  };
  for (SceneProblem& problem : check_fields(text.scene())) add(std::move(problem));
  if (any_fault(result.problems)) return result;

  auto loaded = std::make_unique<LoadedScene>();
  loaded->message = text.scene();
  fill_defaults(options.preset, loaded->message);
  ModelFiles files(source.models);
  SceneProblems problems;
  SceneDescription description =
      translate_scene(loaded->message, options.device_stiffness, files, problems);
  for (SceneProblem& problem : problems) add(std::move(problem));
  if (any_fault(result.problems)) return result;
  for (SceneFinding& finding : check_scene(description)) {
    add({finding.doubt, "", 0, 0, std::move(finding.path), std::move(finding.message),
         std::move(finding.remedy)});
  }
  if (any_fault(result.problems)) return result;

  loaded->scene = std::make_unique<const Scene>(std::move(description));
  loaded->assets = files.assets();
  loaded->hash = hash_of(source.text, loaded->assets);
  result.loaded = std::move(loaded);
  return result;
}

LoadResult refused(const std::string& file, std::string message, std::string remedy) {
  LoadResult result;
  result.problems.push_back({false, file, 0, 0, "", std::move(message), std::move(remedy)});
  return result;
}

/// As load(); a scene too large for this machine is refused like any other.
LoadResult load_guarded(const Source& source, const LoadOptions& options) {
  try {
    return load(source, options);
  } catch (const std::bad_alloc&) {
    return refused(source.file, "it needs more memory than there is", "Use coarser trees.");
  }
}

bool is_file(const std::string& source) {
  return source.find('/') != std::string::npos || source.ends_with(kExtension);
}

/// The file of an installed scene; empty when there is none.
fs::path find_scene(const std::string& name, const ScenePaths& paths) {
  for (const fs::path& folder : paths.scenes) {
    std::error_code ignored;
    fs::path path = folder / (name + std::string(kExtension));
    if (fs::is_regular_file(path, ignored)) return path;
  }
  return {};
}

std::string known_scenes(const ScenePaths& paths) {
  std::string text;
  for (const std::string& name : list_scenes(paths)) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "No scene is installed." : "Installed are " + text + ".";
}

}  // namespace

std::vector<std::string> list_scenes(const ScenePaths& paths) {
  std::set<std::string> names;
  for (const fs::path& folder : paths.scenes) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.path().extension() == kExtension) names.insert(entry.path().stem().string());
    }
  }
  return {names.begin(), names.end()};
}

LoadResult load_scene(const std::string& source, const LoadOptions& options) {
  const fs::path path = is_file(source) ? fs::path(source) : find_scene(source, options.paths);
  if (path.empty()) {
    return refused(source, "there is no scene of this name", known_scenes(options.paths));
  }
  std::vector<std::uint8_t> bytes;
  try {
    bytes = read_file(path, kLongestSceneText);
  } catch (const std::runtime_error& fault) {
    return refused(path.string(), std::string("it ") + fault.what(), "");
  }
  std::vector<fs::path> models{path.parent_path()};
  models.insert(models.end(), options.paths.models.begin(), options.paths.models.end());
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return load_guarded({text, path.string(), std::move(models)}, options);
}

LoadResult load_scene_text(std::string_view text, const LoadOptions& options) {
  return load_guarded({text, "inline", options.paths.models}, options);
}

}  // namespace hapticd
