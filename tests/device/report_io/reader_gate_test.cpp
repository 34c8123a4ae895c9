// Who is let in, and that closing waits for who is in.
#include "device/report_io/reader_gate.h"

#include <doctest/doctest.h>

namespace hapticd::test {

TEST_CASE("the reader is let in while the gate is open and the device not lost") {
  ReaderGate gate;
  CHECK_FALSE(gate.enter());
  gate.open();
  REQUIRE(gate.enter());
  CHECK_FALSE(gate.enter());
  gate.leave(false);
  REQUIRE(gate.enter());
  CHECK_FALSE(gate.failed());
  gate.leave(true);
  CHECK(gate.failed());
  CHECK_FALSE(gate.enter());
  const std::uint32_t before = gate.attachment();
  gate.close();
  CHECK_FALSE(gate.failed());
  CHECK_FALSE(gate.enter());
  gate.open();
  CHECK(gate.attachment() != before);
  CHECK(gate.enter());
  gate.leave(false);
}

TEST_CASE("closing returns when the reader is out, and it is never in afterwards") {
  ReaderGate gate;
  std::atomic<bool> inside{false}, over{false};
  std::thread reader([&] {
    while (!over.load()) {
      if (!gate.enter()) continue;
      inside.store(true);
      inside.store(false);
      gate.leave(false);
    }
  });
  for (int k = 0; k < 200; ++k) {
    gate.open();
    std::this_thread::yield();
    gate.close();
    CHECK_FALSE(inside.load());
  }
  over.store(true);
  reader.join();
}

}  // namespace hapticd::test
