// The reader of recordings over its corpus and mutations of it, without a fuzzer.
#include <doctest/doctest.h>

#include "tests/fuzz/recording_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no mutation of a recording crashes its reader or is repaired to what was not in it") {
  const std::int64_t mutations = scaled(50'000);
  const Replay result = replay("recording", mutations, check_recording_bytes);
  CHECK(result.inputs > mutations);
  CHECK(result.taken >= 3);  // the corpus itself
}

}  // namespace hapticd::test
