// The corpus of handshakes and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/noise_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no bytes pass for a message of the handshake, or keep the true one from being read") {
  const Replay result = replay("noise", scaled(10'000), check_noise_bytes);
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
