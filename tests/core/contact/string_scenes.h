// One fingertip and a few strings: the scenes and motions that the tests of strings in the contact
// problem share. SI, frame W: strings along x from x = 0, the hand above them at y > 0. Not RT.
#pragma once

#include <vector>

#include "core/contact/string_forces.h"
#include "tests/core/contact/rendering_fixture.h"

namespace hapticd::test {

/// Radius of the fingertip, m.
inline constexpr double kTipRadius = 5e-3;

/// 1.1 m of 0.34 mm steel under 30 N, along x at height y and z; it yields and is never tuned.
[[nodiscard]] StringParameters string_at(double y = 0.0, double z = 0.0);

/// A scene of these strings for a tool; without one: a fingertip at the origin of G.
[[nodiscard]] RenderingScene scene_of(const std::vector<StringParameters>& strings,
                                      std::vector<Sphere> tool = {{Vector3::Zero(), kTipRadius}});

/// Distance of the fingertip's centre from the axis of a string it rests on, m.
[[nodiscard]] double rest_distance(double radius);

/// What the hand gets in a tick, each string by its own law.
struct StringTick {
  Wrench F_H_W;
  PressedStrings strings;
};

/// After run.tick or run.tick_along towards X_WH.
[[nodiscard]] StringTick rendered(const ToolRun& run);

/// Moves the hand on a straight way from `from` to `to` in `ticks` ticks, the first one step behind
/// `from`; `each(p_WH)` after every tick.
template <typename Each>
void glide(ToolRun& run, const Vector3& from, const Vector3& to, int ticks, const Each& each) {
  for (int i = 1; i <= ticks; ++i) {
    const Vector3 p_WH = from + (to - from) * (static_cast<double>(i) / ticks);
    run.tick(pose_at(p_WH));
    each(p_WH);
  }
}

inline void glide(ToolRun& run, const Vector3& from, const Vector3& to, int ticks) {
  glide(run, from, to, ticks, [](const Vector3&) {});
}

/// The deflection of a string, zero when it is not held.
[[nodiscard]] Vector3 deflection_of(const ToolRun& run, int string);

}  // namespace hapticd::test
