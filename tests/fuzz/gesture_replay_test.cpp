// The corpus of gestures and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/gesture_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no text crashes the loader of gestures, and a gesture that is taken can be played") {
  const Replay result = replay("gesture", scaled(50'000), check_gesture_bytes);
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
