// The corpus of what pages say and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/page_message_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("whatever pages say is done once or answered, and a page that looks moves nothing") {
  const Replay result = replay("page_message", scaled(50'000), check_page_messages);
  CHECK(result.taken >= 4);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
