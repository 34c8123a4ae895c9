// See shipped_scene.h.
#include "tests/scenario/shipped_scene.h"

#include <doctest/doctest.h>

#include <filesystem>

namespace hapticd::test {

LoadOptions shipped() {
  LoadOptions options;
  options.paths = {{HAPTICD_SCENES_DIR}, {HAPTICD_MODELS_DIR}};
  return options;
}

bool fine_models_exist() {
  return std::filesystem::exists(HAPTICD_MODELS_DIR "/guqin_body_125um.tree");
}

std::unique_ptr<LoadedScene> load_shipped(const std::string& name) {
  LoadResult result = load_scene(name, shipped());
  std::string problems;
  for (const SceneProblem& problem : result.problems) problems += to_text(problem) + "\n";
  REQUIRE_MESSAGE(result.loaded != nullptr, problems);
  CHECK_MESSAGE(result.problems.empty(), problems);
  return std::move(result.loaded);
}

Pose moved_to(const Pose& X, const Vector3& p) { return {X.q, p}; }

}  // namespace hapticd::test
