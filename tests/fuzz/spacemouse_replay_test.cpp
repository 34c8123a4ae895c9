// The corpus of SpaceMouse sessions and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/replay.h"
#include "tests/fuzz/spacemouse_target.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no bytes of a SpaceMouse carry the tool out of its workspace or twist its orientation") {
  const Replay result = replay("spacemouse", scaled(500'000), check_spacemouse_bytes);
  // Three devices, and one that sends halves of reports.
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
