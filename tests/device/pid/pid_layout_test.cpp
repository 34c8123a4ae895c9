// Places of fields against those counted by hand in the descriptor of force_device.h.
#include "device/pid/pid_layout.h"

#include <doctest/doctest.h>

#include "tests/device/pid/force_device.h"

namespace hapticd::test {
namespace {

using pid::BitField;
using pid::LayoutResult;
using pid::PidLayout;

void check_field(const BitField& field, int bit, int bits, std::int64_t minimum,
                 std::int64_t maximum) {
  CHECK(field.bit == bit);
  CHECK(field.bits == bits);
  CHECK(field.minimum == minimum);
  CHECK(field.maximum == maximum);
}

/// What the device lacks when this part of its descriptor is another.
std::string lack_with(Bytes DescriptorParts::*part, const Bytes& bytes) {
  DescriptorParts parts;
  parts.*part = bytes;
  return pid::find_layout(parts.joined()).lack;
}

}  // namespace

TEST_CASE("the reports of a two-axis device are found with the bits that carry each number") {
  const LayoutResult result = pid::find_layout(DescriptorParts().joined());
  REQUIRE(result.lack.empty());
  const PidLayout& layout = result.layout;
  CHECK(layout.input.report.id == 1);
  CHECK(layout.input.report.bytes == 25);
  check_field(layout.input.x, 72, 16, -32'767, 32'767);
  check_field(layout.input.y, 88, 16, -32'767, 32'767);
  check_field(layout.input.button[0], 8, 1, 0, 1);
  check_field(layout.input.button[15], 23, 1, 0, 1);
  CHECK(layout.constant.report.id == 5);
  CHECK(layout.constant.report.bytes == 4);
  check_field(layout.constant.block, 8, 8, 1, 40);
  check_field(layout.constant.magnitude, 16, 16, -32'767, 32'767);
  CHECK(layout.effect.report.bytes == 18);
  check_field(layout.effect.constant.field, 16, 8, 1, 4);
  CHECK(layout.effect.constant.value == 1);
  check_field(layout.effect.duration, 24, 16, 0, 32'767);
  check_field(layout.effect.gain, 72, 8, 0, 255);
  check_field(layout.effect.trigger_button, 80, 8, 1, 8);
  check_field(layout.effect.axis_enable[0].field, 88, 1, 0, 1);
  check_field(layout.effect.axis_enable[1].field, 89, 1, 0, 1);
  check_field(layout.effect.direction_enable.field, 90, 1, 0, 1);
  check_field(layout.effect.direction, 96, 16, 0, 36'000);
  CHECK(layout.operation.report.id == 10);
  CHECK(layout.operation.start.value == 1);
  check_field(layout.operation.loops, 24, 8, 0, 255);
  CHECK(layout.control.report.id == 12);
  CHECK(layout.control.enable.value == 1);
  CHECK(layout.control.disable.value == 2);
  CHECK(layout.control.stop_all.value == 3);
  CHECK(layout.control.reset.value == 4);
  check_field(layout.gain.gain, 8, 8, 0, 255);
  CHECK(layout.create.report.id == 17);
  CHECK(layout.create.report.bytes == 4);
  CHECK(layout.load.report.bytes == 5);
  check_field(layout.load.block, 8, 8, 1, 40);
  check_field(layout.load.success.field, 16, 8, 1, 3);
  CHECK(layout.load.success.value == 1);
}

TEST_CASE("a device that lacks what is needed is refused with the name of it") {
  CHECK(lack_with(&DescriptorParts::axes, {}) == "the X axis");
  CHECK(lack_with(&DescriptorParts::axes, {0x05, 0x01, 0x09, 0x30, 0x15, 0x00, 0x25, 0x7F, 0x75,
                                           0x08, 0x95, 0x01, 0x81, 0x02}) ==
        "the Y axis beside the X axis");
  CHECK(lack_with(&DescriptorParts::constant, {}) ==
        "the Set Constant Force report with its magnitude");
  CHECK(lack_with(&DescriptorParts::operation, {}) == "the Effect Operation report");
  CHECK(lack_with(&DescriptorParts::control, {}) == "Enable Actuators of Device Control");
  CHECK(lack_with(&DescriptorParts::create, {}) == "Create New Effect with the constant force");
  CHECK(lack_with(&DescriptorParts::load, {}) ==
        "the Block Load report with its effect block index");
  DescriptorParts parts;
  parts.direction = parts.axes_enable = {};
  CHECK(pid::find_layout(parts.joined()).lack == "the direction or the axes of Set Effect");
  parts = {};
  parts.effect = parts.axes_enable = parts.direction = parts.effect_end = {};
  parts.constant.insert(parts.constant.begin(), {0x05, 0x0F});
  CHECK(pid::find_layout(parts.joined()).lack ==
        "the Set Effect report with its effect block index");
}

TEST_CASE("a magnitude without a sign is refused: it would push one way only") {
  Bytes unsigned_magnitude = DescriptorParts().constant;
  // Logical minimum 1 - 32768 becomes 0.
  unsigned_magnitude[21] = unsigned_magnitude[22] = 0;
  CHECK(lack_with(&DescriptorParts::constant, unsigned_magnitude) ==
        "a force magnitude of both signs");
}

TEST_CASE("a magnitude that its bits cannot hold is refused: it would come out as another sign") {
  Bytes narrow = DescriptorParts().constant;
  // 8 bits for -32767 to 32767.
  narrow[27] = 0x08;
  CHECK(lack_with(&DescriptorParts::constant, narrow) ==
        "a force magnitude whose range fits its bits");
}

TEST_CASE("a device without a gain, and one that can only enable its motors, will do") {
  CHECK(lack_with(&DescriptorParts::gain, {}).empty());
  // Device Control as one flag for Enable Actuators.
  CHECK(lack_with(
            &DescriptorParts::control,
            {0x09, 0x95, 0xA1, 0x02, 0x85, 0x0C, 0x09, 0x96, 0xA1, 0x02, 0x09, 0x97, 0x15, 0x00,
             0x25, 0x01, 0x75, 0x01, 0x95, 0x01, 0x91, 0x02, 0x95, 0x07, 0x91, 0x01, 0xC0, 0xC0})
            .empty());
}

TEST_CASE("a keyboard and no bytes at all lack the X axis; broken descriptors are no descriptors") {
  const Bytes keyboard{0x05, 0x01, 0x09, 0x06, 0xA1, 0x01, 0x05, 0x07, 0x19, 0xE0, 0x29, 0xE7,
                       0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x08, 0x81, 0x02, 0xC0};
  CHECK(pid::find_layout(keyboard).lack == "the X axis");
  CHECK(pid::find_layout(Bytes{}).lack == "the X axis");
  Bytes cut = DescriptorParts().joined();
  cut.pop_back();
  CHECK(pid::find_layout(cut).lack == "a report descriptor without a flaw");
}

TEST_CASE("a report longer than is read or written is not used") {
  Bytes axes = DescriptorParts().axes;
  // 40 bytes more.
  axes.insert(axes.end(), {0x75, 0x08, 0x95, 0x28, 0x81, 0x03});
  CHECK(lack_with(&DescriptorParts::axes, axes) == "the X axis");
}

TEST_CASE("bits are put and got where they are, low ones first, across bytes, with sign") {
  // 12 bits from bit 13: 5 of them in byte 1, 7 in byte 2.
  const BitField field{13, 12, -2048, 2047};
  Bytes report{0, 0, 0, 0};
  pid::put(field, -2, report);
  // 1111 1111 1110: the low three bits 110 on bits 5..7, then 1 1111 1111.
  CHECK(report == Bytes{0x00, 0xC0, 0xFF, 0x01});
  CHECK(pid::get(field, report) == -2);
  report = {0xFF, 0xFF, 0xFF, 0xFF};
  pid::put(field, 5, report);
  CHECK(report == Bytes{0xFF, 0xBF, 0x00, 0xFE});
  CHECK(pid::get(field, report) == 5);
  CHECK(pid::get({13, 12, 0, 4095}, Bytes{0x00, 0xC0, 0xFF, 0x01}) == 4094);
  CHECK(pid::get(field, Bytes{0xFF, 0xFF, 0xFF}) == 0);
}

}  // namespace hapticd::test
