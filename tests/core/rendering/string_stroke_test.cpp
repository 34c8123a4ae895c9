// The law for strings that yield: the tool never passes through or sinks into a string that bends
// under it, judged on the way of tool AND string between committed configurations. A control that
// moves the string without looking must fail on the same strokes.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/core/rendering/strokes.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Allowed depth of the committed path, m.
constexpr long double kAllowedDepth = 1e-6L;

/// Deepest point of the whole committed path of a stroke (m, negative = penetration).
long double path_gap(const Stroke& stroke) {
  ToolRun run(stroke.scene, stroke.X_WH.front());
  long double deepest = 1.0L;
  for (const Pose& X_WH : stroke.X_WH) deepest = std::min(deepest, run.tick_along(X_WH));
  return deepest;
}

}  // namespace

TEST_CASE(
    "no stroke from 0.1 to 100 m/s sinks into strings that yield or passes through them by more "
    "than "
    "a micrometre") {
  const std::int64_t strokes = scaled(100'000);
  long double deepest = 1.0L;
  for (std::int64_t i = 0; i < strokes; ++i) {
    const Stroke stroke = make_string_stroke(static_cast<std::uint64_t>(i));
    const long double gap = path_gap(stroke);
    deepest = std::min(deepest, gap);
    if (gap < -kAllowedDepth)
      FAIL_CHECK("stroke " << i << ": " << static_cast<double>(gap) << " m, " << stroke.describe());
  }
  MESSAGE("deepest point of " << strokes << " committed paths: " << static_cast<double>(deepest)
                              << " m");
  CHECK(deepest >= -kAllowedDepth);
}

}  // namespace hapticd::test
