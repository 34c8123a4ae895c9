// A scene as clients are sent it, so that they can change it and send it back: every default filled
// in except what another choice decides. That is the quality, whose level has its own settings and
// which hapticd may have been started with. Its effect is given separately. Offline.
#pragma once

#include "core/simulation/live_settings.h"
#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/control.pb.h"
#include "hapticd/v1/scene.pb.h"

namespace hapticd {

/// What a scene says itself of its quality.
struct GivenQuality {
  v1::Quality choice;  ///< the usual level where there is none
  v1::Solver solver;
};

/// Of `scene` as it is written.
[[nodiscard]] GivenQuality given_quality(const v1::Scene& scene);

/// Takes out of `scene`, all filled in, the knobs that its quality has decided.
void leave_open(const GivenQuality& given, v1::Scene& scene);

/// The choice after `set`, which was obeyed.
void follow_choice(const v1::SetParameter& set, v1::Quality& choice);

/// Tells `scene` (knobs left open, its quality the one in force) with `choice` as its quality, and
/// what is in force.
void tell_scene(const v1::Scene& scene, const v1::Quality& choice, v1::SceneInfo& info);

/// Takes `live` to `level` as set_level does (core/scene/quality.h); knobs that `given` has stand
/// whatever they are.
void take_to_level(int level, const v1::Solver& given, LiveSettings& live);

}  // namespace hapticd
