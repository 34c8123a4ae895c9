// The ladder of quality goes up in effort and down in error.
#include "core/scene/quality.h"

#include <doctest/doctest.h>

namespace hapticd::test {

TEST_CASE("each level works at least as hard as the one below, for less error") {
  for (int level = 1; level < kQualityLevels; ++level) {
    CAPTURE(level);
    CHECK(quality_of(level).options.sub_steps > quality_of(level - 1).options.sub_steps);
    CHECK(quality_of(level).options.stop_tolerance <= quality_of(level - 1).options.stop_tolerance);
    CHECK(quality_of(level).force_error < quality_of(level - 1).force_error);
  }
}

TEST_CASE("the default level is the optimiser's own default") {
  const OptimiserOptions usual;
  const OptimiserOptions level = quality_of(kDefaultQuality).options;
  CHECK(level.sub_steps == usual.sub_steps);
  CHECK(level.stop_tolerance == usual.stop_tolerance);
  CHECK(level.rotation_step == usual.rotation_step);
}

TEST_CASE("the cheapest level within an error is chosen, the best where none is") {
  for (int level = 0; level < kQualityLevels; ++level) {
    CHECK(quality_for(quality_of(level).force_error) == level);
  }
  CHECK(quality_for(1.0) == 0);
  CHECK(quality_for(1e-12) == kQualityLevels - 1);
}

}  // namespace hapticd::test
