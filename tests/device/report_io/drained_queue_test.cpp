// A queue read to its end, with a queue that counts what it gave. Truth: what was put in.
#include "device/report_io/drained_queue.h"

#include <doctest/doctest.h>

#include <vector>

namespace hapticd::test {
namespace {

/// Reports of one byte, their number; -1 at the end of a device that is gone.
struct Queue {
  int waiting = 0;
  bool gone = false;
  int given = 0;

  static int read(void* input, std::uint8_t* bytes, std::size_t /*room*/) noexcept {
    auto& self = *static_cast<Queue*>(input);
    if (self.given == self.waiting) return self.gone ? -1 : 0;
    bytes[0] = static_cast<std::uint8_t>(self.given++);
    return 1;
  }
  Drained drain() {
    ReportChannel channel;
    channel.input = this;
    channel.read = read;
    return drain_queue(channel, [this](std::span<const std::uint8_t> bytes) {
      taken.push_back(bytes.size() == 1 ? bytes[0] : -1);
    });
  }

  std::vector<int> taken{};
};

}  // namespace

TEST_CASE("all that waits is given, oldest first") {
  for (const int waiting : {0, 1, 2, 62}) {
    CAPTURE(waiting);
    Queue queue{waiting};
    CHECK(queue.drain() == Drained::kAll);
    REQUIRE(queue.taken.size() == static_cast<std::size_t>(waiting));
    for (int k = 0; k < waiting; ++k) CHECK(queue.taken[static_cast<std::size_t>(k)] == k);
  }
}

TEST_CASE(
    "a queue that was full has overflowed, and one that never ends is left after 64 reports") {
  Queue full{63};
  CHECK(full.drain() == Drained::kOverflow);
  Queue endless{1'000};
  CHECK(endless.drain() == Drained::kOverflow);
  CHECK(endless.given == 64);
}

TEST_CASE("a device that is gone is told after what waited") {
  Queue queue{3, true};
  CHECK(queue.drain() == Drained::kLost);
  CHECK(queue.taken.size() == 3);
}

}  // namespace hapticd::test
