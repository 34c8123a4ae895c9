// See pid_layout.h.
#include "device/pid/pid_layout.h"

#include <algorithm>

#include "device/api/report_channel.h"

namespace hapticd::pid {
namespace {

constexpr std::uint32_t desktop(std::uint32_t usage) { return usage_of(0x01, usage); }
constexpr std::uint32_t button(std::uint32_t usage) { return usage_of(0x09, usage); }
constexpr std::uint32_t force(std::uint32_t usage) { return usage_of(0x0F, usage); }
constexpr std::uint32_t simulation(std::uint32_t usage) { return usage_of(0x02, usage); }

/// Application collections that a hand holds a stick of: joystick, game pad, multi-axis controller;
/// flight simulation device, airplane simulation device, flight control stick, flight stick.
constexpr std::array kSticks{desktop(0x04),    desktop(0x05),    desktop(0x08),   simulation(0x01),
                             simulation(0x09), simulation(0x20), simulation(0x21)};

// Names of the class definition.
constexpr std::uint32_t kX = desktop(0x30);
constexpr std::uint32_t kY = desktop(0x31);
constexpr std::uint32_t kSetEffectReport = force(0x21);
constexpr std::uint32_t kEffectBlockIndex = force(0x22);
constexpr std::uint32_t kConstantForce = force(0x26);
constexpr std::uint32_t kDuration = force(0x50);
constexpr std::uint32_t kGain = force(0x52);
constexpr std::uint32_t kTriggerButton = force(0x53);
constexpr std::uint32_t kAxesEnable = force(0x55);
constexpr std::uint32_t kDirectionEnable = force(0x56);
constexpr std::uint32_t kDirection = force(0x57);
constexpr std::uint32_t kMagnitude = force(0x70);
constexpr std::uint32_t kSetConstantForceReport = force(0x73);
constexpr std::uint32_t kEffectOperationReport = force(0x77);
constexpr std::uint32_t kStart = force(0x79);
constexpr std::uint32_t kLoopCount = force(0x7C);
constexpr std::uint32_t kDeviceGainReport = force(0x7D);
constexpr std::uint32_t kDeviceGain = force(0x7E);
constexpr std::uint32_t kBlockLoadReport = force(0x89);
constexpr std::uint32_t kBlockLoadSuccess = force(0x8C);
constexpr std::uint32_t kStateReport = force(0x92);
constexpr std::uint32_t kDevicePaused = force(0x9F);
constexpr std::uint32_t kActuatorsEnabled = force(0xA0);
constexpr std::uint32_t kSafetySwitch = force(0xA4);
constexpr std::uint32_t kOverrideSwitch = force(0xA5);
constexpr std::uint32_t kActuatorPower = force(0xA6);
constexpr std::uint32_t kDeviceControlReport = force(0x95);
constexpr std::uint32_t kDeviceControl = force(0x96);
constexpr std::uint32_t kEnableActuators = force(0x97);
constexpr std::uint32_t kDisableActuators = force(0x98);
constexpr std::uint32_t kStopAllEffects = force(0x99);
constexpr std::uint32_t kDeviceReset = force(0x9A);
constexpr std::uint32_t kCreateNewEffectReport = force(0xAB);

BitField bits_of(const Field& field) {
  return {static_cast<std::uint16_t>(field.bit), static_cast<std::uint8_t>(field.bits),
          field.minimum, field.maximum};
}

/// Bytes of a report that can be used; 0: it is too long, or has no ID.
std::size_t usable_bytes(const Descriptor& descriptor, ReportKind kind, std::uint8_t id) {
  for (const ReportSize& report : descriptor.reports) {
    if (report.kind != kind || report.id != id || id == 0) continue;
    const std::size_t bytes = (report.bits + 7) / 8;
    return bytes <= kMaxReport ? bytes : 0;
  }
  return 0;
}

/// A report of the descriptor, and the fields in it that lie in a collection of this usage, within
/// the collection numbered `scope`; 0 and -1: in any.
class Finder {
 public:
  Finder(const Descriptor& descriptor, int scope, ReportKind kind, std::uint32_t collection)
      : descriptor_(descriptor), scope_(scope), kind_(kind), collection_(collection) {}

  /// The report that has the field with this usage; an unusable one has no bytes.
  ReportForm fix_report(std::uint32_t usage) {
    for (const Field& field : descriptor_.fields) {
      if (!is_mine(field) || !has(field, usage)) continue;
      const std::size_t bytes = usable_bytes(descriptor_, kind_, field.report_id);
      if (bytes == 0) continue;
      report_ = {field.report_id, static_cast<std::uint8_t>(bytes)};
      break;
    }
    return report_;
  }

  /// A variable with this usage.
  [[nodiscard]] BitField variable(std::uint32_t usage) const {
    for (const Field& field : descriptor_.fields) {
      if (is_fixed(field) && !field.is_array && has(field, usage)) return bits_of(field);
    }
    return {};
  }

  /// The first variable within a collection of this usage, whatever its own: directions are named
  /// by ordinal.
  [[nodiscard]] BitField first_within(std::uint32_t usage) const {
    for (const Field& field : descriptor_.fields) {
      if (is_fixed(field) && !field.is_array && is_within(descriptor_, field.collection, usage)) {
        return bits_of(field);
      }
    }
    return {};
  }

  /// A flag with this usage within a collection of usage `around`.
  [[nodiscard]] Choice flag_within(std::uint32_t usage, std::uint32_t around) const {
    for (const Field& field : descriptor_.fields) {
      if (is_fixed(field) && !field.is_array && has(field, usage) &&
          is_within(descriptor_, field.collection, around)) {
        return {bits_of(field), 1};
      }
    }
    return {};
  }

  /// What says this: an array's entry, or a separate flag.
  [[nodiscard]] Choice choice(std::uint32_t usage) const {
    for (const Field& field : descriptor_.fields) {
      if (!is_fixed(field)) continue;
      const auto place = std::find(field.usages.begin(), field.usages.end(), usage);
      if (place == field.usages.end()) continue;
      if (!field.is_array) return {bits_of(field), 1};
      const std::int64_t value = field.minimum + (place - field.usages.begin());
      if (value <= field.maximum) return {bits_of(field), value};
    }
    return {};
  }

 private:
  [[nodiscard]] static bool has(const Field& field, std::uint32_t usage) {
    return std::find(field.usages.begin(), field.usages.end(), usage) != field.usages.end();
  }
  [[nodiscard]] bool is_mine(const Field& field) const {
    return field.kind == kind_ &&
           (scope_ == -1 || is_inside(descriptor_, field.collection, scope_)) &&
           (collection_ == 0 || is_within(descriptor_, field.collection, collection_));
  }
  [[nodiscard]] bool is_fixed(const Field& field) const {
    return report_.bytes != 0 && field.report_id == report_.id && is_mine(field);
  }

  const Descriptor& descriptor_;
  int scope_;
  ReportKind kind_;
  std::uint32_t collection_;
  ReportForm report_;
};

/// The sticks of a descriptor: the numbers of their collections.
std::vector<int> sticks_of(const Descriptor& descriptor) {
  std::vector<int> sticks;
  for (std::size_t k = 0; k < descriptor.collections.size(); ++k) {
    const Collection& each = descriptor.collections[k];
    const bool is_stick = std::find(kSticks.begin(), kSticks.end(), each.usage) != kSticks.end();
    if (each.is_application && is_stick) sticks.push_back(static_cast<int>(k));
  }
  return sticks;
}

/// True when something in this stick's collection sets effects.
bool sets_effects(const Descriptor& descriptor, int stick) {
  return std::any_of(descriptor.fields.begin(), descriptor.fields.end(), [&](const Field& field) {
    return field.kind == ReportKind::kOutput && is_inside(descriptor, field.collection, stick) &&
           is_within(descriptor, field.collection, kSetEffectReport);
  });
}

/// A place of the stick's handle along an axis: not a change, not in a collection of another
/// device.
const Field* find_axis(const Descriptor& descriptor, int stick, std::uint32_t usage,
                       std::uint8_t report_id) {
  for (const Field& field : descriptor.fields) {
    const bool fits = field.kind == ReportKind::kInput && !field.is_array && !field.is_relative &&
                      field.maximum > field.minimum && field.usages.size() == 1 &&
                      field.usages.front() == usage && field.report_id == report_id &&
                      application_of(descriptor, field.collection) == stick;
    if (fits) return &field;
  }
  return nullptr;
}

/// The axes of a stick, in one report.
void find_axes(const Descriptor& descriptor, int stick, PidLayout::Input& input) {
  for (const ReportSize& report : descriptor.reports) {
    const std::size_t bytes = usable_bytes(descriptor, ReportKind::kInput, report.id);
    if (report.kind != ReportKind::kInput || bytes == 0) continue;
    const Field* const x = find_axis(descriptor, stick, kX, report.id);
    const Field* const y = find_axis(descriptor, stick, kY, report.id);
    if (x == nullptr || (y == nullptr && input.x.exists())) continue;
    input.report = {report.id, static_cast<std::uint8_t>(bytes)};
    input.x = bits_of(*x);
    input.y = y == nullptr ? BitField{} : bits_of(*y);
    if (y != nullptr) return;
  }
}

/// The stick that pushes, or else the first one; -1: there is none.
int find_input(const Descriptor& descriptor, PidLayout::Input& input) {
  const std::vector<int> sticks = sticks_of(descriptor);
  const auto pushes = std::find_if(sticks.begin(), sticks.end(),
                                   [&](int stick) { return sets_effects(descriptor, stick); });
  if (sticks.empty()) return -1;
  const int stick = pushes == sticks.end() ? sticks.front() : *pushes;
  find_axes(descriptor, stick, input);
  for (const Field& field : descriptor.fields) {
    const bool fits = field.kind == ReportKind::kInput && !field.is_array &&
                      field.report_id == input.report.id && input.report.bytes != 0 &&
                      field.usages.size() == 1 &&
                      application_of(descriptor, field.collection) == stick;
    if (!fits) continue;
    const std::uint32_t number = field.usages.front() - button(1);
    if (number < kMaxButtons && !input.button[number].exists()) {
      input.button[number] = bits_of(field);
    }
  }
  return stick;
}

void find_state(const Descriptor& descriptor, int scope, PidLayout::State& state) {
  for (const std::uint32_t usage :
       {kActuatorsEnabled, kSafetySwitch, kActuatorPower, kDevicePaused, kOverrideSwitch}) {
    if (state.report.bytes != 0) break;
    Finder in(descriptor, scope, ReportKind::kInput, kStateReport);
    state.report = in.fix_report(usage);
    state.paused = in.variable(kDevicePaused);
    state.actuators = in.variable(kActuatorsEnabled);
    state.power = in.variable(kActuatorPower);
    state.safety_switch = in.variable(kSafetySwitch);
    state.force_switch = in.variable(kOverrideSwitch);
  }
}

/// Set Effect says by itself which axes an effect is along, and they are not X and Y: a wheel.
bool lacks_an_axis(const Descriptor& descriptor, int scope, const PidLayout::SetEffect& effect) {
  const bool names_axes =
      std::any_of(descriptor.fields.begin(), descriptor.fields.end(), [&](const Field& field) {
        return field.kind == ReportKind::kOutput && field.report_id == effect.report.id &&
               (scope == -1 || is_inside(descriptor, field.collection, scope)) &&
               is_within(descriptor, field.collection, kAxesEnable);
      });
  return names_axes &&
         !(effect.axis_enable[0].field.exists() && effect.axis_enable[1].field.exists());
}

void find_effect(const Descriptor& descriptor, int scope, PidLayout::SetEffect& effect) {
  Finder out(descriptor, scope, ReportKind::kOutput, kSetEffectReport);
  effect.report = out.fix_report(kEffectBlockIndex);
  effect.block = out.variable(kEffectBlockIndex);
  effect.constant = out.choice(kConstantForce);
  effect.duration = out.variable(kDuration);
  effect.gain = out.variable(kGain);
  effect.trigger_button = out.variable(kTriggerButton);
  effect.direction_enable = out.choice(kDirectionEnable);
  effect.direction = out.first_within(kDirection);
  if (!effect.direction.exists()) effect.direction = out.variable(kDirection);
  effect.axis_enable = {out.flag_within(kX, kAxesEnable), out.flag_within(kY, kAxesEnable)};
}

void find_outputs(const Descriptor& descriptor, int scope, PidLayout& layout) {
  Finder constant(descriptor, scope, ReportKind::kOutput, kSetConstantForceReport);
  layout.constant.report = constant.fix_report(kMagnitude);
  layout.constant.block = constant.variable(kEffectBlockIndex);
  layout.constant.magnitude = constant.variable(kMagnitude);
  Finder operation(descriptor, scope, ReportKind::kOutput, kEffectOperationReport);
  layout.operation.report = operation.fix_report(kEffectBlockIndex);
  layout.operation.block = operation.variable(kEffectBlockIndex);
  layout.operation.start = operation.choice(kStart);
  layout.operation.loops = operation.variable(kLoopCount);
  // Some devices have the collection of the field alone, and none of the report around it.
  for (const std::uint32_t around : {kDeviceControlReport, kDeviceControl}) {
    if (layout.control.report.bytes != 0) break;
    Finder control(descriptor, scope, ReportKind::kOutput, around);
    layout.control.report = control.fix_report(kEnableActuators);
    layout.control.enable = control.choice(kEnableActuators);
    layout.control.reset = control.choice(kDeviceReset);
    layout.control.stop_all = control.choice(kStopAllEffects);
    layout.control.disable = control.choice(kDisableActuators);
  }
  Finder gain(descriptor, scope, ReportKind::kOutput, kDeviceGainReport);
  layout.gain.report = gain.fix_report(kDeviceGain);
  layout.gain.gain = gain.variable(kDeviceGain);
}

void find_features(const Descriptor& descriptor, int scope, PidLayout& layout) {
  Finder create(descriptor, scope, ReportKind::kFeature, kCreateNewEffectReport);
  layout.create.report = create.fix_report(kConstantForce);
  layout.create.constant = create.choice(kConstantForce);
  Finder load(descriptor, scope, ReportKind::kFeature, kBlockLoadReport);
  layout.load.report = load.fix_report(kEffectBlockIndex);
  layout.load.block = load.variable(kEffectBlockIndex);
  layout.load.success = load.choice(kBlockLoadSuccess);
}

/// Whether every number of the range of a field with sign can be written: one that cannot would
/// come out as a push the other way.
bool fits(const BitField& field) {
  const std::int64_t half = std::int64_t{1} << (field.bits - 1);
  return field.minimum >= -half && field.maximum < half;
}

/// The first thing without which nothing works; null: all is there.
const char* first_lack(const PidLayout& layout) {
  struct Need {
    bool met;
    const char* what;
  };
  const BitField& magnitude = layout.constant.magnitude;
  const auto& effect = layout.effect;
  const bool can_direct =
      (effect.direction_enable.field.exists() && effect.direction.exists()) ||
      (effect.axis_enable[0].field.exists() && effect.axis_enable[1].field.exists());
  const std::array needs{
      Need{layout.input.x.exists(), "the X axis"},
      Need{layout.input.y.exists(), "the Y axis beside the X axis"},
      Need{magnitude.exists(), "the Set Constant Force report with its magnitude"},
      Need{magnitude.minimum < 0 && magnitude.maximum > 0, "a force magnitude of both signs"},
      Need{!magnitude.exists() || fits(magnitude), "a force magnitude whose range fits its bits"},
      Need{layout.constant.block.exists(), "the effect block index of Set Constant Force"},
      Need{effect.block.exists(), "the Set Effect report with its effect block index"},
      Need{can_direct, "the direction or the axes of Set Effect"},
      Need{layout.operation.block.exists(), "the Effect Operation report"},
      Need{layout.operation.start.field.exists(), "the start of Effect Operation"},
      Need{layout.control.enable.field.exists(), "Enable Actuators of Device Control"},
      Need{layout.create.constant.field.exists(), "Create New Effect with the constant force"},
      Need{layout.load.block.exists(), "the Block Load report with its effect block index"},
      Need{layout.load.success.field.exists(), "the success of Block Load"},
  };
  for (const Need& need : needs) {
    if (!need.met) return need.what;
  }
  return nullptr;
}

}  // namespace

LayoutResult find_layout(std::span<const std::uint8_t> bytes) {
  LayoutResult result;
  const Descriptor descriptor = read_fields(bytes);
  if (descriptor.flaw != DescriptorFlaw::kNone) {
    result.lack = "a report descriptor without a flaw";
    return result;
  }
  const int stick = find_input(descriptor, result.layout.input);
  // Some makers put what pushes beside the stick's collection.
  const int scope = stick != -1 && sets_effects(descriptor, stick) ? stick : -1;
  find_state(descriptor, scope, result.layout.state);
  find_effect(descriptor, scope, result.layout.effect);
  find_outputs(descriptor, scope, result.layout);
  find_features(descriptor, scope, result.layout);
  if (const char* lack = first_lack(result.layout)) result.lack = lack;
  if (result.lack.empty() && lacks_an_axis(descriptor, scope, result.layout.effect)) {
    result.lack = "a second axis to push along: Set Effect enables one alone, as wheels do";
  }
  return result;
}

void put(const BitField& field, std::int64_t value, std::span<std::uint8_t> report) noexcept {
  const auto bits = static_cast<std::uint64_t>(value);
  for (std::size_t i = 0; i < field.bits; ++i) {
    const std::size_t at = field.bit + i;
    const auto mask = static_cast<std::uint8_t>(1U << (at % 8));
    std::uint8_t& byte = report[at / 8];
    byte = static_cast<std::uint8_t>((bits >> i & 1U) != 0 ? byte | mask : byte & ~mask);
  }
}

std::int64_t get(const BitField& field, std::span<const std::uint8_t> report) noexcept {
  if (!field.exists() || std::size_t{field.bit} + field.bits > 8 * report.size()) return 0;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < field.bits; ++i) {
    const std::size_t at = field.bit + i;
    value |= std::uint64_t{report[at / 8] >> (at % 8) & 1U} << i;
  }
  const bool negative = field.minimum < 0 && (value >> (field.bits - 1U) & 1U) != 0;
  return static_cast<std::int64_t>(value) - (negative ? std::int64_t{1} << field.bits : 0);
}

}  // namespace hapticd::pid
