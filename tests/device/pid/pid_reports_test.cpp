// Reports against bytes written by hand, and the order of the start-up against Linux's hid-pidff.
#include "device/pid/pid_reports.h"

#include <doctest/doctest.h>

#include <limits>

#include "tests/device/pid/force_device.h"

namespace hapticd::test {
namespace {

Bytes bytes_of(const OutputReport& report) {
  return {report.bytes.begin(), report.bytes.begin() + report.length};
}

pid::PidLayout layout_of(const DescriptorParts& parts) {
  const pid::LayoutResult result = pid::find_layout(parts.joined());
  REQUIRE(result.lack.empty());
  return result.layout;
}

pid::PidLayout layout() { return layout_of({}); }

}  // namespace

TEST_CASE("Set Constant Force has the block and the magnitude, low byte first") {
  CHECK(bytes_of(pid::set_force(layout(), 3, 1234.0)) == Bytes{5, 3, 0xD2, 0x04});
  CHECK(bytes_of(pid::set_force(layout(), 4, -2.0)) == Bytes{5, 4, 0xFE, 0xFF});
}

TEST_CASE("a magnitude is never more than asked for, nor than the device can be told") {
  CHECK(bytes_of(pid::set_force(layout(), 3, 2.99)) == Bytes{5, 3, 2, 0});
  CHECK(bytes_of(pid::set_force(layout(), 3, -2.99)) == Bytes{5, 3, 0xFE, 0xFF});
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double large : {1e9, 1e300, kInf}) {
    CHECK(bytes_of(pid::set_force(layout(), 3, large)) == Bytes{5, 3, 0xFF, 0x7F});
    CHECK(bytes_of(pid::set_force(layout(), 3, -large)) == Bytes{5, 3, 0x01, 0x80});
  }
  CHECK(bytes_of(pid::set_force(layout(), 3, std::numeric_limits<double>::quiet_NaN())) ==
        Bytes{5, 3, 0, 0});
}

TEST_CASE("Set Effect is an infinite constant force at full gain along its axis") {
  // Direction enable is bit 2; 9000 of 36000 is a quarter turn, 18000 half a turn.
  CHECK(bytes_of(pid::set_effect(layout(), 3, 0)) ==
        Bytes{1, 3, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF, 0x04, 0x28, 0x23, 0, 0, 0, 0});
  CHECK(bytes_of(pid::set_effect(layout(), 4, 1)) ==
        Bytes{1, 4, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF, 0x04, 0x50, 0x46, 0, 0, 0, 0});
}

TEST_CASE("a device without a direction is told the axis of each effect") {
  DescriptorParts parts;
  parts.direction = {0x95, 0x06, 0x91, 0x03};
  CHECK(bytes_of(pid::set_effect(layout_of(parts), 3, 0)) ==
        Bytes{1, 3, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF, 0x01, 0, 0});
  CHECK(bytes_of(pid::set_effect(layout_of(parts), 4, 1)) ==
        Bytes{1, 4, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF, 0x02, 0, 0});
}

TEST_CASE(
    "the start-up resets, enables, sets the gain, and starts an effect for each axis at zero") {
  ForceDevice device;
  const pid::StartResult result = pid::start(layout(), device.channel());
  CHECK(result.problem.empty());
  CHECK(result.blocks == pid::EffectBlocks{3, 4});
  const std::vector<Bytes> expected{
      {12, 4},
      {12, 1},
      {13, 0xFF},
      {17, 1, 0, 0},
      {1, 3, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF, 0x04, 0x28, 0x23, 0, 0, 0, 0},
      {5, 3, 0, 0},
      {10, 3, 1, 1},
      {17, 1, 0, 0},
      {1, 4, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF, 0x04, 0x50, 0x46, 0, 0, 0, 0},
      {5, 4, 0, 0},
      {10, 4, 1, 1}};
  CHECK(device.sent() == expected);
}

TEST_CASE("an effect that takes its time to load is waited for, and one that never does is not") {
  ForceDevice slow;
  slow.set_load(pid::kBlockLoadTries - 1, 1);
  CHECK(pid::start(layout(), slow.channel()).problem.empty());
  ForceDevice full;
  full.set_load(0, 2);
  CHECK(pid::start(layout(), full.channel()).problem == "it has no room for a constant effect");
}

TEST_CASE("a device with one constant effect, and one that is gone, cannot be started") {
  ForceDevice one;
  one.set_load(0, 1, true);
  CHECK(pid::start(layout(), one.channel()).problem == "it has one constant effect for both axes");
  ForceDevice gone;
  gone.lose();
  CHECK(pid::start(layout(), gone.channel()).problem ==
        "it does not take the reports that enable it");
}

TEST_CASE("the end is zero on both axes, all effects stopped, motors off") {
  ForceDevice device;
  pid::stop(layout(), {3, 4}, device.channel());
  CHECK(device.sent() == std::vector<Bytes>{{5, 3, 0, 0}, {5, 4, 0, 0}, {12, 3}, {12, 2}});
}

}  // namespace hapticd::test
