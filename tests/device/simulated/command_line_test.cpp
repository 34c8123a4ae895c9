// Truth: the instants of the definition.
#include "device/simulated/command_line.h"

#include <doctest/doctest.h>

#include <limits>

namespace hapticd::test {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

DeviceCommand push(double force) {
  DeviceCommand command;
  command.f_H_D = {force, 0.0, 0.0};
  command.enable = true;
  return command;
}

double force_at(CommandLine& line, std::int64_t t_ns) { return line.at(t_ns).F_H_D.f.x(); }

}  // namespace

TEST_CASE("a command takes effect the declared delay after it was sent, to the nanosecond") {
  CommandLine line(2.5e-3, kNone);
  line.send(1'000, push(3.0));
  CHECK(force_at(line, 2'500'999) == 0.0);
  CHECK(!line.at(2'500'999).enabled);
  CHECK(force_at(line, 2'501'000) == 3.0);
  CHECK(line.at(2'501'000).enabled);
}

TEST_CASE("each command holds until the next arrives, many of them on their way at once") {
  CommandLine line(0.1, kNone);
  for (int i = 0; i < 1000; ++i) REQUIRE(line.send(std::int64_t{100'000} * i, push(i)));
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(force_at(line, 100'000'000 + i * 100'000) == i);
    REQUIRE(force_at(line, 100'000'000 + i * 100'000 + 99'999) == i);
  }
}

TEST_CASE("a command that expires ends on the device's side, the delay later") {
  CommandLine line(1e-3, kNone);
  DeviceCommand command = push(1.0);
  command.expires_ns = 5'000'000;
  line.send(0, command);
  CHECK(force_at(line, 5'999'999) == 1.0);
  CHECK(force_at(line, 6'000'000) == 0.0);
}

TEST_CASE("a disabled device does not push") {
  CommandLine line(0.0, kNone);
  DeviceCommand command = push(1.0);
  command.enable = false;
  line.send(0, command);
  CHECK(force_at(line, 0) == 0.0);
  CHECK(!line.at(0).enabled);
}

TEST_CASE("zero written past the loop ends what was sent before, and not what is sent after") {
  CommandLine line(1e-3, kNone);
  line.send(0, push(1.0));
  CHECK(force_at(line, 1'000'000) == 1.0);
  line.send_zero(2'000'000);
  CHECK(force_at(line, 2'999'999) == 1.0);
  CHECK(force_at(line, 3'000'000) == 0.0);
  line.send(4'000'000, push(2.0));
  CHECK(force_at(line, 4'999'999) == 0.0);
  CHECK(force_at(line, 5'000'000) == 2.0);
  line.send_zero(1'500'000);
  CHECK(force_at(line, 6'000'000) == 2.0);
}

TEST_CASE("the watchdog cuts the force when nothing came for its time, and any command ends that") {
  CommandLine line(0.0, 0.02);
  line.send(0, push(1.0));
  CHECK(force_at(line, 19'999'999) == 1.0);
  CHECK(!line.at(19'999'999).stale);
  CHECK(force_at(line, 20'000'000) == 0.0);
  CHECK(line.at(20'000'000).stale);
  line.send(21'000'000, push(1.0));
  CHECK(force_at(line, 21'000'000) == 1.0);
}

TEST_CASE("a full line refuses, and works again when commands have arrived") {
  CommandLine line(0.0, kNone);
  for (std::size_t i = 0; i < kCommandsOnTheWay; ++i) REQUIRE(line.send(0, push(1.0)));
  CHECK(!line.send(0, push(9.0)));
  CHECK(force_at(line, 0) == 1.0);
  CHECK(line.send(1, push(2.0)));
  CHECK(force_at(line, 1) == 2.0);
}

}  // namespace hapticd::test
