// The corpus of configurations and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/configuration_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE(
    "no text crashes the reader of configurations, and none is taken with a number out of range") {
  const Replay result = replay("configuration", scaled(50'000), check_configuration_bytes);
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
