// See pid_reports.h.
#include "device/pid/pid_reports.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace hapticd::pid {
namespace {

std::span<std::uint8_t> bytes_of(OutputReport& report) noexcept {
  return std::span(report.bytes).first(report.length);
}

void put_if(const BitField& field, std::int64_t value, OutputReport& report) noexcept {
  if (field.exists()) put(field, value, bytes_of(report));
}

void choose(const Choice& choice, OutputReport& report) noexcept {
  put_if(choice.field, choice.value, report);
}

bool write(const ReportChannel& channel, const OutputReport& report) {
  return channel.write(channel.output, report.bytes.data(), report.length) >= 0;
}

/// Loads one constant effect; false with the problem.
bool load_effect(const PidLayout& layout, const ReportChannel& channel, std::uint8_t& block,
                 std::string& problem) {
  const OutputReport create = create_effect(layout);
  if (channel.set_feature(channel.output, create.bytes.data(), create.length) < 0) {
    problem = "it creates no constant effect";
    return false;
  }
  for (int tries = 0; tries < kBlockLoadTries; ++tries) {
    OutputReport load = blank(layout.load.report);
    const int length = channel.get_feature(channel.output, load.bytes.data(), load.length);
    if (length < 0) {
      problem = "it does not say whether an effect was created";
      return false;
    }
    const std::span<const std::uint8_t> answer(
        load.bytes.data(), std::min<std::size_t>(static_cast<std::size_t>(length), load.length));
    const std::int64_t loaded = get(layout.load.block, answer);
    const Choice& success = layout.load.success;
    // 0 is not a block, and no device of the class has one beyond a byte.
    if (get(success.field, answer) == success.value && loaded > 0 && loaded <= 0xFF) {
      block = static_cast<std::uint8_t>(loaded);
      return true;
    }
  }
  problem = "it has no room for a constant effect";
  return false;
}

bool start_axis(const PidLayout& layout, const ReportChannel& channel, std::size_t axis,
                StartResult& result) {
  std::uint8_t& block = result.blocks[axis];
  if (!load_effect(layout, channel, block, result.problem)) return false;
  if (axis == 1 && block == result.blocks[0]) {
    result.problem = "it has one constant effect for both axes";
    return false;
  }
  const bool taken = write(channel, set_effect(layout, block, axis)) &&
                     write(channel, set_force(layout, block, 0.0)) &&
                     write(channel, start_effect(layout, block));
  if (!taken) result.problem = "it does not take the reports of an effect";
  return taken;
}

}  // namespace

OutputReport blank(const ReportForm& form) noexcept {
  OutputReport report;
  report.length = form.bytes;
  report.bytes[0] = form.id;
  return report;
}

OutputReport control(const PidLayout& layout, const Choice& what) noexcept {
  OutputReport report = blank(layout.control.report);
  choose(what, report);
  return report;
}

OutputReport full_gain(const PidLayout& layout) noexcept {
  OutputReport report = blank(layout.gain.report);
  put_if(layout.gain.gain, layout.gain.gain.maximum, report);
  return report;
}

OutputReport create_effect(const PidLayout& layout) noexcept {
  OutputReport report = blank(layout.create.report);
  choose(layout.create.constant, report);
  return report;
}

OutputReport set_effect(const PidLayout& layout, std::uint8_t block, std::size_t axis) noexcept {
  const PidLayout::SetEffect& effect = layout.effect;
  OutputReport report = blank(effect.report);
  put_if(effect.block, block, report);
  choose(effect.constant, report);
  // All ones is the null value of a duration, and infinity to the devices that read it as a number.
  constexpr std::int64_t kAllOnes = -1;
  put_if(effect.duration, kAllOnes, report);
  put_if(effect.trigger_button, kAllOnes, report);
  put_if(effect.gain, effect.gain.maximum, report);
  if (effect.direction_enable.field.exists() && effect.direction.exists()) {
    choose(effect.direction_enable, report);
    const BitField& direction = effect.direction;
    // A quarter of a turn is +X, half a turn +Y.
    const std::int64_t turn = direction.maximum - direction.minimum;
    put(direction, direction.minimum + (axis == 0 ? (turn + 2) / 4 : (turn + 1) / 2),
        bytes_of(report));
  } else {
    choose(effect.axis_enable[axis], report);
  }
  return report;
}

OutputReport start_effect(const PidLayout& layout, std::uint8_t block) noexcept {
  OutputReport report = blank(layout.operation.report);
  put_if(layout.operation.block, block, report);
  choose(layout.operation.start, report);
  put_if(layout.operation.loops, 1, report);
  return report;
}

OutputReport set_force(const PidLayout& layout, std::uint8_t block, double magnitude) noexcept {
  const BitField& field = layout.constant.magnitude;
  OutputReport report = blank(layout.constant.report);
  put_if(layout.constant.block, block, report);
  if (std::isnan(magnitude)) magnitude = 0.0;
  const double cut =
      std::clamp(magnitude, static_cast<double>(field.minimum), static_cast<double>(field.maximum));
  put_if(field, static_cast<std::int64_t>(cut), report);
  return report;
}

StartResult start(const PidLayout& layout, const ReportChannel& channel) {
  StartResult result;
  const PidLayout::Control& known = layout.control;
  const bool reset = !known.reset.field.exists() || write(channel, control(layout, known.reset));
  const bool enabled = reset && write(channel, control(layout, known.enable));
  const bool gained =
      enabled && (layout.gain.report.bytes == 0 || write(channel, full_gain(layout)));
  if (!gained) {
    result.problem = "it does not take the reports that enable it";
    return result;
  }
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    if (!start_axis(layout, channel, axis, result)) return result;
  }
  return result;
}

void stop(const PidLayout& layout, const EffectBlocks& blocks, const ReportChannel& channel) {
  for (const std::uint8_t block : blocks) write(channel, set_force(layout, block, 0.0));
  for (const Choice& what : {layout.control.stop_all, layout.control.disable}) {
    if (what.field.exists()) write(channel, control(layout, what));
  }
}

}  // namespace hapticd::pid
