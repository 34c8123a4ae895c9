// See told_scene.h.
#include "server/scene_io/told_scene.h"

#include <string>

#include "core/scene/quality.h"
#include "server/scene_io/scene_defaults.h"
#include "server/scene_io/solver_knobs.h"

namespace hapticd {

GivenQuality given_quality(const v1::Scene& scene) {
  GivenQuality given{scene.quality(), scene.solver()};
  fill_quality(given.choice);
  return given;
}

void leave_open(const GivenQuality& given, v1::Scene& scene) {
  leave_to_quality(given.solver, *scene.mutable_solver());
}

void follow_choice(const v1::SetParameter& set, v1::Quality& choice) {
  for (const v1::Assignment& assignment : set.assignments()) {
    if (assignment.path() == "quality.automatic.budget_us") {
      choice.mutable_automatic()->set_budget_us(assignment.number());
    } else if (assignment.path() == "quality" && assignment.has_number()) {
      choice.set_level(static_cast<std::uint32_t>(assignment.number()));
    } else if (assignment.path() == "quality") {
      choice.mutable_automatic();  // the budget stays, where it was given
    }
  }
}

void tell_scene(const v1::Scene& scene, const v1::Quality& choice, v1::SceneInfo& info) {
  *info.mutable_scene() = scene;
  *info.mutable_scene()->mutable_quality() = choice;
  v1::Quality& quality = *info.mutable_quality_in_force();
  quality = scene.quality();
  if (!quality.has_automatic()) {
    quality.set_level(static_cast<std::uint32_t>(quality_level(scene.quality())));
  }
  *info.mutable_solver_in_force() = scene.solver();
  fill_knobs(scene.quality(), *info.mutable_solver_in_force());
}

void take_to_level(int level, const v1::Solver& given, LiveSettings& live) {
  set_level(level, live);
  keep_from_quality(given, live.contact);
}

}  // namespace hapticd
