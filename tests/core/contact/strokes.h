// Seeded strokes of a haptic tool against strings and bodies: the inputs of the penetration tests.
// Every kind the device can do: across, oblique, along, at the end caps, by rotation alone, from
// both sides, 0.1 to 100 m/s, spheres of 0.1 to 10 mm; and what it cannot: jumps of up to 10 m
// within one tick.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/random.h"

namespace hapticd::test {

/// Radius of the strings, m.
inline constexpr double kStringRadius = 0.34e-3;

enum class StrokeKind : std::uint8_t {
  kAcross,
  kOblique,
  kAxial,
  kEndCap,
  kRotation,
  kScrew,
  kTeleport
};
inline constexpr int kStrokeKinds = 7;

struct Stroke {
  StrokeKind kind;
  double speed;  ///< m/s, of the tool's contact sphere; a teleport has none
  RenderingScene scene;
  std::vector<Pose> X_WH;  ///< per tick of 1 ms; [0] is free of contact
  [[nodiscard]] std::string describe() const;
};

/// Stroke `seed`; start poses are free of contact by at least 0.1 mm.
[[nodiscard]] Stroke make_stroke(std::uint64_t seed);

/// The same kinds of strokes against one to three strings that yield, slack ones to taut ones, some
/// of them with friction and with lateral force.
[[nodiscard]] Stroke make_string_stroke(std::uint64_t seed);

}  // namespace hapticd::test
