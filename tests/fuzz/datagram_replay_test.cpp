// The corpus of datagrams and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/datagram_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no datagram makes the server send what it must not, or keep a session for ever") {
  const Replay result = replay("datagram", scaled(20'000), check_datagram_bytes);
  CHECK(result.taken >= 4);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
