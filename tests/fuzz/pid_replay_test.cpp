// The corpus of descriptors of force devices and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/pid_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no descriptor makes the PID driver reach outside a report or push the other way") {
  const Replay result = replay("pid", scaled(200'000), check_pid_bytes);
  // The corpus has two devices that can be used, and one that cannot.
  CHECK(result.taken >= 2);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
