// The corpus of device profiles and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/device_profile_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no text crashes the reader of profiles, and none is taken with a number out of range") {
  const Replay result = replay("device_profile", scaled(50'000), check_device_profile_bytes);
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
