// The exchange of clocks. PROTOCOL.md, section 7.
#include "proto/wire/clock_exchange.h"

#include <doctest/doctest.h>

namespace hapticd::wire {
namespace {

v1::Clock clock_of(std::uint64_t echoed, std::uint64_t received, std::uint64_t sent) {
  v1::Clock clock;
  clock.set_echoed_ns(echoed);
  clock.set_received_ns(received);
  clock.set_sent_ns(sent);
  return clock;
}

TEST_CASE("a Clock is answered once, with the times of its arrival and of the answer") {
  ClockEcho echo;
  v1::Packet packet;
  echo.fill(packet, 5);
  CHECK(!packet.has_clock());
  echo.take(clock_of(0, 0, 1000), 20);
  echo.fill(packet, 30);
  CHECK(packet.clock().echoed_ns() == 1000);
  CHECK(packet.clock().received_ns() == 20);
  CHECK(packet.clock().sent_ns() == 30);
  v1::Packet next;
  echo.fill(next, 40);
  CHECK(!next.has_clock());
}

TEST_CASE("a Clock that was overtaken by a newer one is not answered") {
  ClockEcho echo;
  echo.take(clock_of(0, 0, 1000), 20);
  echo.take(clock_of(0, 0, 900), 25);
  v1::Packet packet;
  echo.fill(packet, 30);
  CHECK(packet.clock().echoed_ns() == 1000);
}

TEST_CASE("round trip and offset are those of the document's formulas") {
  // Server 100 ahead; 30 out, 5 kept, 10 back.
  const auto sample = clock_sample(clock_of(1000, 1130, 1135), 1045);
  REQUIRE(sample.has_value());
  CHECK(sample->round_trip_ns == (1045 - 1000) - (1135 - 1130));
  CHECK(sample->offset_ns == ((1130 - 1000) + (1135 - 1045)) / 2);
}

TEST_CASE("times that contradict each other, or that no clock shows, give no sample") {
  CHECK(!clock_sample(clock_of(0, 10, 20), 100).has_value());
  CHECK(!clock_sample(clock_of(200, 10, 20), 100).has_value());
  CHECK(!clock_sample(clock_of(50, 20, 10), 100).has_value());
  CHECK(!clock_sample(clock_of(50, 0, 100), 100).has_value());
  const std::uint64_t far = ~std::uint64_t{0};
  CHECK(!clock_sample(clock_of(far, 10, 20), 100).has_value());
  CHECK(!clock_sample(clock_of(50, far, far), 100).has_value());
  CHECK(!clock_sample(clock_of(50, 10, far), 100).has_value());
}

}  // namespace
}  // namespace hapticd::wire
