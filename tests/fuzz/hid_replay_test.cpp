// The corpus of HID reports and descriptors and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/hid_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no bytes make a HID report what it is not, or a device push beyond its limits") {
  const Replay result = replay("hid", scaled(1'000'000), check_hid_bytes);
  // All of the corpus but the session, which is many reports in one.
  CHECK(result.taken >= 9);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
