// See string_scenes.h.
#include "tests/core/contact/string_scenes.h"

#include <utility>

namespace hapticd::test {

StringParameters string_at(double y, double z) {
  StringParameters string;
  string.p_WA = {0.0, y, z};
  string.p_WB = {1.1, y, z};
  return string;
}

RenderingScene scene_of(const std::vector<StringParameters>& strings, std::vector<Sphere> tool) {
  RenderingScene scene(std::move(tool));
  for (const StringParameters& string : strings) {
    scene.capsules_W.push_back({to_vector(string.p_WA), to_vector(string.p_WB), string.radius});
    scene.strings.push_back(derive_string(string));
  }
  return scene;
}

double rest_distance(double radius) { return kTipRadius + radius; }

StringTick rendered(const ToolRun& run) {
  StringTick tick;
  find_string_contacts(run.problem->view(), tick.strings, tick.F_H_W);
  return tick;
}

Vector3 deflection_of(const ToolRun& run, int string) {
  for (const TouchedString& hold : run.state.touched) {
    if (hold.bend.capsule == string) return hold.bend.u_W;
  }
  return Vector3::Zero();
}

}  // namespace hapticd::test
