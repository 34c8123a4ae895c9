// See pid_driver.h.
#include "device/pid/pid_driver.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/rt/monotonic_clock.h"
#include "device/pid/pid_device.h"
#include "device/pid/pid_reports.h"
#include "device/report_io/hidraw_handles.h"

namespace hapticd::pid {
namespace {

namespace fs = std::filesystem;

std::int64_t now() noexcept { return monotonic_now_ns(); }

/// Usage of the top-level collection, its page in the upper half; 0: it has none.
std::uint32_t top_usage(const HidrawNode& node) {
  const Descriptor descriptor = read_fields(node.descriptor);
  return descriptor.collections.empty() ? 0 : descriptor.collections.front().usage;
}

/// Numbers of `match` that fit; -1: one does not.
int fitting(const DeviceMatch& match, const HidrawNode& node) {
  constexpr unsigned kPageShift = 16;
  constexpr std::uint32_t kUsageMask = 0xFFFF;
  const std::uint32_t usage = top_usage(node);
  int numbers = 0;
  bool fits = true;
  const auto compare = [&](const auto& wanted, const auto& there) {
    if (!wanted) return;
    ++numbers;
    fits = fits && *wanted == there;
  };
  compare(match.vendor_id, node.vendor_id);
  compare(match.product_id, node.product_id);
  compare(match.usage_page, usage >> kPageShift);
  compare(match.usage, usage & kUsageMask);
  compare(match.serial, node.serial);
  return fits ? numbers : -1;
}

std::vector<DeviceSheet> installed_ones(const FoundDevice& found) {
  std::vector<DeviceSheet> sheets = found.installed();
  std::erase_if(
      sheets, [](const DeviceSheet& sheet) { return sheet.profile.driver != DeviceDriver::kPid; });
  return sheets;
}

std::string hex_id(std::uint16_t id) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "0x%04x", unsigned{id});
  return text.data();
}

std::string what_to_write(const HidrawNode& node, const PidLayout& layout) {
  const BitField& x = layout.input.x;
  return "Copy the profile openffboard.textproto and write into it matches { vendor_id: " +
         hex_id(node.vendor_id) + " product_id: " + hex_id(node.product_id) +
         " }, as position_scale the metres that its handle moves along x divided by " +
         std::to_string(x.maximum - x.minimum) +
         ", and as force_scale the newtons that it gives at most divided by " +
         std::to_string(layout.constant.magnitude.maximum) +
         "; then name the file as the profile of the device in --config";
}

/// A warning of others that may push with the device; empty: nobody may.
std::string warning_of_others(const HidrawNode& node) {
  std::string inputs;
  for (const std::string& input : force_inputs(node)) inputs += " " + input;
  if (inputs.empty()) return "";
  return "the kernel's hid-pidff lets other programs push with it too. While hapticd runs, let no "
         "game, Wine, Steam or fftest use it, or take it from them: sudo chmod 600" +
         inputs;
}

class PidPlug final : public Plug {
 public:
  PidPlug(PidDevice& device, const HidrawNode& known, const PidLayout& layout)
      : device_(device), descriptor_(known.descriptor), layout_(layout) {}

  [[nodiscard]] std::string attach(const HidrawNode& node, const ReportChannel& channel) override {
    if (node.descriptor != descriptor_) {
      throw DeviceError(node, "it is a different device with the same serial as before",
                        "Restart hapticd to use it.");
    }
    const StartResult started = start(layout_, channel);
    if (!started.problem.empty()) throw DeviceError(node, started.problem, "Plug it in again.");
    device_.attach(channel, started.blocks);
    return warning_of_others(node);
  }
  void detach() override { device_.detach(); }
  [[nodiscard]] bool failed() const noexcept override { return device_.failed(); }

 private:
  PidDevice& device_;
  std::vector<std::uint8_t> descriptor_;
  PidLayout layout_;
};

}  // namespace

bool is_mine(const HidrawNode& node) { return find_layout(node.descriptor).lack.empty(); }

DeviceSheet matching_sheet(const HidrawNode& node, const DeviceSheet& chosen,
                           std::span<const DeviceSheet> installed) {
  if (device_name(chosen.profile) != kDriver.profile) return chosen;
  const DeviceSheet* best = &chosen;
  int most = 0;
  for (const DeviceSheet& sheet : installed) {
    for (const DeviceMatch& match : sheet.matches) {
      const int numbers = fitting(match, node);
      if (numbers <= most) continue;
      most = numbers;
      best = &sheet;
    }
  }
  return *best;
}

DeviceSheet unwatched_sheet(const HidrawNode& node, const PidLayout& layout,
                            const DeviceSheet& chosen) {
  if (is_open(chosen, &AxisMapping::force_scale) || is_open(chosen, &AxisMapping::position_scale)) {
    throw DeviceError(node, "no profile says what a unit of its position and force is",
                      what_to_write(node, layout) + ".");
  }
  DeviceSheet sheet = chosen;
  sheet.profile.driver = DeviceDriver::kPid;
  leave_open(sheet, &DeviceProfile::watchdog);
  if (sheet.description.empty()) sheet.description = describe(node);
  sheet.description += "; no device watchdog: 1 N at most";
  limit(sheet, &DeviceProfile::peak_force, kUnwatchedForce, "there is no device watchdog");
  return sheet;
}

std::vector<std::string> force_inputs(const HidrawNode& node, const std::string& sys) {
  std::vector<std::string> found;
  std::error_code none;
  const fs::path inputs =
      fs::path(sys) / "class/hidraw" / fs::path(node.path).filename() / "device/input";
  for (const fs::directory_entry& input : fs::directory_iterator(inputs, none)) {
    std::string effects;
    std::getline(std::ifstream(input.path() / "capabilities/ff"), effects);
    if (effects.find_first_not_of("0 ") == std::string::npos) continue;
    for (const fs::directory_entry& event : fs::directory_iterator(input.path(), none)) {
      const std::string name = event.path().filename();
      if (name.starts_with("event")) found.push_back("/dev/input/" + name);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

OpenDevice open(const FoundDevice& found) {
  const PidLayout layout = find_layout(found.node.descriptor).layout;
  const DeviceSheet matching = matching_sheet(found.node, found.chosen, installed_ones(found));
  const DeviceGrant granted = found.grant(
      {unwatched_sheet(found.node, layout, matching), found.node.descriptor, {true, true, false}});
  auto device = std::make_unique<PidDevice>(
      granted.sheet.profile,
      PidSettings{granted.sheet.axes, layout, !granted.sheet.profile.switches_unwired}, now);
  OpenDevice opened;
  opened.warnings.emplace_back(
      "experimental. There is no device watchdog: if hapticd dies while it pushes, it pushes on. "
      "Never more than 1 N");
  opened.plug = std::make_unique<PidPlug>(*device, found.node, layout);
  opened.device = std::move(device);
  return opened;
}

}  // namespace hapticd::pid
