// The corpus of connections and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/page_connection_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE(
    "whatever a peer sends, its connection ends with it, and without the token it moves nothing") {
  const Replay result = replay("page_connection", scaled(4'000), check_page_connection);
  CHECK(result.taken >= 4);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
