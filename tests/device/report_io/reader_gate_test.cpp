// Who is let in, and that closing waits for who is in.
#include "device/report_io/reader_gate.h"

#include <doctest/doctest.h>
#include <pthread.h>
#include <sched.h>

#include "tests/support/skip.h"

namespace hapticd::test {
namespace {

/// This thread and those it starts run on the processor it is on, as long as this lives.
struct Pinned {
  Pinned() {
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
    worked = pthread_getaffinity_np(pthread_self(), sizeof all, &all) == 0 &&
             pthread_setaffinity_np(pthread_self(), sizeof one, &one) == 0;
  }
  ~Pinned() {
    if (worked) pthread_setaffinity_np(pthread_self(), sizeof all, &all);
  }
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

  cpu_set_t all{};
  cpu_set_t one{};
  bool worked = false;
};

}  // namespace

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

TEST_CASE("on one processor a gate closes although its reader is nearly always in") {
  const Pinned pinned;
  if (!pinned.worked) {
    skip("no thread may be pinned here");
    return;
  }
  constexpr int kMaxVisits = 20'000;
  ReaderGate gate;
  gate.open();
  REQUIRE(gate.enter());
  std::thread closer([&] { gate.close(); });
  std::atomic<int> work{0};
  int visits = 0;
  for (; visits < kMaxVisits; ++visits) {
    // Long enough for the other thread to have its turn in here, not between leave and enter.
    for (int k = 0; k < 50'000; ++k) work.fetch_add(k, std::memory_order_relaxed);
    gate.leave(false);
    if (!gate.enter()) break;
  }
  CHECK(visits < kMaxVisits);
  if (visits == kMaxVisits) gate.leave(false);
  closer.join();
  CHECK_FALSE(gate.enter());
}

}  // namespace hapticd::test
