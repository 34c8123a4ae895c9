// Which Packets of Items may be under way, and when they begin again. PROTOCOL.md, section 4.
#include "proto/wire/packets_ahead.h"

#include <doctest/doctest.h>

#include <vector>

namespace hapticd::wire {
namespace {

/// Packets of one Item each that leave until there is no room.
std::size_t fill(PacketsAhead& packets, std::int64_t now_ns) {
  std::size_t count = 0;
  for (; packets.room(); ++count) packets.left(packets.next_id(), packets.next_id(), now_ns);
  return count;
}

/// One whose peer takes `ahead` Packets and acknowledges all after a round trip; five of them.
PacketsAhead after_five(std::uint32_t ahead, std::int64_t round_trip_ns) {
  PacketsAhead packets;
  packets.allow(ahead);
  for (int i = 0; i < 5; ++i) {
    fill(packets, i * round_trip_ns);
    packets.acknowledged(packets.next_id() - 1, (i + 1) * round_trip_ns);
  }
  return packets;
}

TEST_CASE("one Packet is under way at first, and twice as many with every round trip") {
  PacketsAhead packets;
  packets.allow(32);
  std::vector<std::size_t> left;
  for (int i = 0; i < 8; ++i) {
    left.push_back(fill(packets, i * kMillisecond_ns));
    packets.acknowledged(packets.next_id() - 1, (i + 1) * kMillisecond_ns);
  }
  CHECK(left == std::vector<std::size_t>{1, 2, 4, 8, 16, 32, 32, 32});
}

TEST_CASE("as many as are acknowledged leave, and no more than were announced") {
  PacketsAhead packets = after_five(5, kMillisecond_ns);
  CHECK(fill(packets, 5 * kMillisecond_ns) == 5);
  packets.acknowledged(packets.next_id() - 3, 6 * kMillisecond_ns);
  CHECK(fill(packets, 6 * kMillisecond_ns) == 3);
}

TEST_CASE("the largest announcement counts, and no more than 32 whatever is announced") {
  PacketsAhead packets = after_five(7, kMillisecond_ns);
  packets.allow(3);
  CHECK(fill(packets, kMillisecond_ns) == 7);
  PacketsAhead greedy = after_five(0xffffffff, kMillisecond_ns);
  CHECK(fill(greedy, kMillisecond_ns) == 32);
}

TEST_CASE("what nobody announced is not allowed") {
  PacketsAhead packets;
  CHECK(!packets.allowed());
  packets.allow(0);
  CHECK(!packets.allowed());
  packets.allow(1);
  CHECK(packets.allowed());
}

TEST_CASE("half as many begin again two round trips and 1 ms after the last progress") {
  constexpr std::int64_t kTrip_ns = 4 * kMillisecond_ns;
  PacketsAhead packets = after_five(32, kTrip_ns);
  std::int64_t now_ns = 5 * kTrip_ns;
  const std::uint64_t oldest = packets.next_id();
  CHECK(fill(packets, now_ns) == 32);
  CHECK(packets.due_ns() == now_ns + 2 * kTrip_ns + kMillisecond_ns);
  now_ns += kTrip_ns;
  packets.acknowledged(oldest + 2, now_ns);
  CHECK(packets.due_ns() == now_ns + 2 * kTrip_ns + kMillisecond_ns);
  CHECK(fill(packets, now_ns + 1) == 3);  // New ones do not put it off.
  CHECK(packets.due_ns() == now_ns + 2 * kTrip_ns + kMillisecond_ns);
  now_ns = packets.due_ns();
  packets.turn_back(now_ns);
  CHECK(packets.next_id() == oldest + 3);
  CHECK(fill(packets, now_ns) == 16);
  // From now on one more for every round trip.
  for (std::size_t wide = 17; wide < 20; ++wide) {
    now_ns += kTrip_ns;
    packets.acknowledged(packets.next_id() - 1, now_ns);
    CHECK(fill(packets, now_ns) == wide);
  }
}

TEST_CASE("when nothing arrives although some were repeated, one Packet is, on the schedule") {
  PacketsAhead packets = after_five(32, kMillisecond_ns);
  std::int64_t now_ns = 5 * kMillisecond_ns;
  CHECK(fill(packets, now_ns) == 32);
  std::vector<std::size_t> left;
  std::vector<std::int64_t> waited_ms;
  for (int i = 0; i < 8; ++i) {
    waited_ms.push_back((packets.due_ns() - now_ns) / kMillisecond_ns);
    now_ns = packets.due_ns();
    packets.turn_back(now_ns);
    left.push_back(fill(packets, now_ns));
  }
  CHECK(left == std::vector<std::size_t>{16, 1, 1, 1, 1, 1, 1, 1});
  CHECK(waited_ms == std::vector<std::int64_t>{3, 4, 4, 8, 16, 50, 50, 50});
}

TEST_CASE("an acknowledgement that was late moves on what has turned back") {
  PacketsAhead packets = after_five(8, kMillisecond_ns);
  const std::uint64_t oldest = packets.next_id();
  fill(packets, 5 * kMillisecond_ns);
  packets.turn_back(8 * kMillisecond_ns);
  packets.left(oldest, oldest, 8 * kMillisecond_ns);
  packets.acknowledged(oldest + 7, 9 * kMillisecond_ns);
  CHECK(packets.next_id() == oldest + 8);
  CHECK(packets.due_ns() == kNever_ns);
}

TEST_CASE("a road that has become ten times slower is believed, and nothing leaves twice then") {
  PacketsAhead packets = after_five(32, kMillisecond_ns);
  constexpr std::int64_t kTrip_ns = 30 * kMillisecond_ns;
  std::int64_t now_ns = 5 * kMillisecond_ns;
  int turns = 0;
  for (int trip = 0; trip < 400; ++trip) {
    fill(packets, now_ns);
    const std::uint64_t last = packets.next_id() - 1;
    const std::int64_t acknowledged_ns = now_ns + kTrip_ns;
    turns = 0;
    while (packets.due_ns() < acknowledged_ns) {
      now_ns = packets.due_ns();
      packets.turn_back(now_ns);
      fill(packets, now_ns);
      ++turns;
    }
    now_ns = acknowledged_ns;
    packets.acknowledged(last, now_ns);
  }
  CHECK(turns == 0);
  CHECK(fill(packets, now_ns) == 32);
}

}  // namespace
}  // namespace hapticd::wire
