// See scene_loader.h.
#include "server/scene_io/scene_loader.h"

#include <new>
#include <sstream>

#include "core/scene/quality.h"
#include "core/scene/scene_check.h"
#include "server/scene_io/field_check.h"
#include "server/scene_io/idle_fields.h"
#include "server/scene_io/message_text.h"
#include "server/scene_io/named_text.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/scene_parameters.h"
#include "server/scene_io/scene_translation.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

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

/// A doubt where no level promises the error that is asked for, which the most exact one then has
/// to do for.
void doubt_quality(const v1::Quality& quality, SceneProblems& problems) {
  if (!quality.has_max_force_error() || quality_offers(quality.max_force_error())) return;
  std::ostringstream message;
  message << "no level of quality promises a force error of " << quality.max_force_error()
          << "; the most exact, " << quality_level(quality) << ", promises "
          << quality_of(quality_level(quality)).force_error << " and is played";
  problems.push_back({true, "", 0, 0, "quality.max_force_error", message.str(),
                      "Ask for no less, or give the solver's knobs yourself."});
}

std::string bytes_of(const ContentHash& hash) { return {hash.begin(), hash.end()}; }

/// The fault of a scene that cannot be sent to clients; empty: it can.
SceneProblems too_long_to_tell(const LoadedScene& loaded, std::size_t longest) {
  const std::size_t bytes = describe_scene(loaded).ByteSizeLong();
  if (bytes <= longest) return {};
  return {{false, "", 0, 0, "",
           "what clients have to be told of the scene (SceneInfo) has " + std::to_string(bytes) +
               " bytes, more than " + std::to_string(longest),
           "Put spheres into tree files, and give lines fewer points."}};
}

LoadResult load(const Source& source, const LoadOptions& options) {
  LoadResult result;
  v1::Scene written;
  const MessageText text(source.text, source.file, "scene", written);
  result.problems = text.problems();
  if (any_fault(result.problems)) return result;
  const auto add = [&](SceneProblem problem) {
    result.problems.push_back(text.located(std::move(problem)));
  };
  for (SceneProblem& problem : check_fields(written)) add(std::move(problem));
  if (any_fault(result.problems)) return result;

  auto loaded = std::make_unique<LoadedScene>();
  loaded->message = written;
  loaded->given = given_quality(written);
  choose_quality(options.quality, loaded->message);
  fill_defaults(options.preset, loaded->message);
  ModelFiles files(source.models, options.brought);
  SceneProblems problems;
  doubt_quality(loaded->message.quality(), problems);
  SceneDescription description =
      translate_scene(loaded->message, options.device_stiffness, files, problems);
  for (SceneProblem& problem : problems) add(std::move(problem));
  if (any_fault(result.problems)) return result;
  for (SceneFinding& finding : check_scene(description)) {
    add({finding.doubt, "", 0, 0, std::move(finding.path), std::move(finding.message),
         std::move(finding.remedy)});
  }
  if (any_fault(result.problems)) return result;

  for (SceneProblem& problem : idle_fields(written, description)) add(std::move(problem));

  loaded->assets = files.assets();
  loaded->brought = options.brought;
  loaded->hash = hash_of(source.text, loaded->assets);
  for (SceneProblem& problem : too_long_to_tell(*loaded, options.longest_info)) {
    add(std::move(problem));
  }
  if (any_fault(result.problems)) return result;
  loaded->scene = std::make_unique<const Scene>(std::move(description));
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

LoadResult load_named(const NamedText& named, const LoadOptions& options) {
  if (named.problem) {
    LoadResult result;
    result.problems.push_back(*named.problem);
    result.missing = true;
    return result;
  }
  std::vector<fs::path> models{named.path.parent_path()};
  models.insert(models.end(), options.paths.models.begin(), options.paths.models.end());
  return load_guarded({named.text, named.path.string(), std::move(models)}, options);
}

}  // namespace

v1::SceneInfo describe_scene(const LoadedScene& loaded) {
  v1::SceneInfo info;
  *info.mutable_scene() = loaded.message;
  info.set_hash(bytes_of(loaded.hash));
  for (const SceneAsset& asset : loaded.assets) {
    v1::Asset& out = *info.add_assets();
    out.set_name(asset.name);
    out.set_hash(bytes_of(asset.hash));
    out.set_size(asset.size);
  }
  for (v1::ParameterInfo& parameter : live_parameters(loaded.message)) {
    *info.add_parameters() = std::move(parameter);
  }
  return info;
}

LoadResult load_installed_scene(const std::string& name, const LoadOptions& options) {
  return load_named(read_installed(name, options.paths.scenes, "scene", kMaxText), options);
}

LoadResult load_scene(const std::string& source, const LoadOptions& options) {
  return load_named(read_named(source, options.paths.scenes, "scene", kMaxText), options);
}

LoadResult load_scene_text(std::string_view text, const LoadOptions& options) {
  return load_guarded({text, "inline", options.paths.models}, options);
}

}  // namespace hapticd
