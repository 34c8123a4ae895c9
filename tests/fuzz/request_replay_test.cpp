// The corpus of requests and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/replay.h"
#include "tests/fuzz/request_target.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no request reaches the loop but one that it can obey, and each has one answer") {
  const Replay result = replay("request", scaled(5'000), check_requests);
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
