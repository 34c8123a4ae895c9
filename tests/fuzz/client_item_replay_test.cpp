// The corpus of what servers say and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/client_item_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no server makes a client crash, hoard, or show what a terminal obeys") {
  const Replay result = replay("client_item", scaled(20'000), check_client_items);
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
