// The corpus of scenes and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/replay.h"
#include "tests/fuzz/scene_target.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no text crashes the loader of scenes, and a scene that is taken can be played") {
  const Replay result = replay("scene", scaled(50'000), check_scene_bytes);
  CHECK(result.taken >= 4);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
