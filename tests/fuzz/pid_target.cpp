// See pid_target.h.
#include "tests/fuzz/pid_target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "device/pid/pid_layout.h"
#include "device/pid/pid_reports.h"

namespace hapticd::test {
namespace {

using pid::BitField;
using pid::PidLayout;

void require(bool condition) {
  if (!condition) throw std::logic_error("a PID descriptor did what it must not");
}

void check_descriptor(std::span<const std::uint8_t> bytes) {
  const pid::Descriptor descriptor = pid::read_fields(bytes);
  require(descriptor.fields.size() <= pid::kMaxFields);
  require(descriptor.reports.size() <= kMaxReports);
  require(descriptor.collections.size() <= pid::kMaxCollections);
  if (descriptor.flaw != DescriptorFlaw::kNone) require(descriptor.reports.empty());
  for (const pid::Field& field : descriptor.fields) {
    require(field.bits >= 1 && field.bits <= 32 && field.minimum <= field.maximum);
    const auto report = std::find_if(descriptor.reports.begin(), descriptor.reports.end(),
                                     [&](const pid::ReportSize& each) {
                                       return each.kind == field.kind && each.id == field.report_id;
                                     });
    require(report != descriptor.reports.end() && field.bit + field.bits <= report->bits);
  }
}

void check_field(const BitField& field, const pid::ReportForm& report) {
  require(!field.exists() || field.bit >= 8);
  require(std::size_t{field.bit} + field.bits <= 8 * std::size_t{report.bytes});
}

void check_report(const OutputReport& report, const pid::ReportForm& form) {
  require(report.length == form.bytes && report.length <= kMaxReport);
  require(report.bytes[0] == form.id && form.id != 0);
}

void check_forces(const PidLayout& layout) {
  const BitField& magnitude = layout.constant.magnitude;
  for (const double force : {0.0, 0.7, -0.7, 1.0, -1.0, 127.5, -127.5, 3e4, -3e4, 1e9, -1e300}) {
    const OutputReport report = pid::set_force(layout, 1, force);
    check_report(report, layout.constant.report);
    const auto told = static_cast<double>(pid::get(magnitude, report.bytes));
    require(std::abs(told) <= std::abs(force) && told * force >= 0.0);
  }
}

void check_layout(const PidLayout& layout) {
  check_field(layout.input.x, layout.input.report);
  check_field(layout.input.y, layout.input.report);
  for (const BitField& button : layout.input.button) check_field(button, layout.input.report);
  const PidLayout::State& state = layout.state;
  for (const BitField& said :
       {state.paused, state.actuators, state.power, state.safety_switch, state.force_switch}) {
    check_field(said, state.report);
  }
  check_field(layout.constant.block, layout.constant.report);
  check_field(layout.constant.magnitude, layout.constant.report);
  check_field(layout.effect.direction, layout.effect.report);
  check_field(layout.load.block, layout.load.report);
  check_field(layout.load.success.field, layout.load.report);
  check_forces(layout);
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
    check_report(pid::set_effect(layout, 1, axis), layout.effect.report);
  }
  check_report(pid::start_effect(layout, 1), layout.operation.report);
  check_report(pid::control(layout, layout.control.enable), layout.control.report);
  check_report(pid::create_effect(layout), layout.create.report);
  if (layout.gain.report.bytes != 0) check_report(pid::full_gain(layout), layout.gain.report);
}

}  // namespace

bool check_pid_bytes(std::span<const std::uint8_t> bytes) {
  check_descriptor(bytes);
  const pid::LayoutResult result = pid::find_layout(bytes);
  if (!result.lack.empty()) return false;
  check_layout(result.layout);
  return true;
}

}  // namespace hapticd::test
