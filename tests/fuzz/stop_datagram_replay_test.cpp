// The corpus of datagrams of the Stop road and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/replay.h"
#include "tests/fuzz/stop_datagram_target.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE(
    "no datagram stops or holds the force off but by this machine or by a new word under the key") {
  const Replay result = replay("stop_datagram", scaled(200'000), check_stop_datagrams);
  CHECK(result.taken >= 4);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
