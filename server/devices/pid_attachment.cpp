// See pid_attachment.h.
#include "server/devices/pid_attachment.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "core/rt/monotonic_clock.h"
#include "device/hid/report_descriptor.h"
#include "device/pid/pid_device.h"
#include "device/pid/pid_reports.h"
#include "server/devices/profile_numbers.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

std::int64_t now() noexcept { return monotonic_now_ns(); }

/// Usage of the top-level collection, its page in the upper half; 0: it has none.
std::uint32_t top_usage(const HidrawNode& node) {
  const pid::Descriptor descriptor = pid::read_fields(node.descriptor);
  return descriptor.collections.empty() ? 0 : descriptor.collections.front().usage;
}

/// Numbers of `match` that fit; -1: one does not.
int fitting(const v1::DeviceMatch& match, const HidrawNode& node) {
  constexpr unsigned kPageShift = 16;
  constexpr std::uint32_t kUsageMask = 0xFFFF;
  const std::uint32_t usage = top_usage(node);
  int numbers = 0;
  bool fits = true;
  const auto compare = [&](bool given, bool same) {
    if (!given) return;
    ++numbers;
    fits = fits && same;
  };
  compare(match.has_vendor_id(), match.vendor_id() == node.vendor_id);
  compare(match.has_product_id(), match.product_id() == node.product_id);
  compare(match.has_usage_page(), match.usage_page() == usage >> kPageShift);
  compare(match.has_usage(), match.usage() == (usage & kUsageMask));
  compare(match.has_serial(), match.serial() == node.serial);
  return fits ? numbers : -1;
}

std::vector<v1::DeviceProfile> installed_pid_profiles() {
  std::vector<v1::DeviceProfile> found;
  const ProfileFolders folders = installed_profiles();
  const std::vector<std::string> names = list_profiles(folders);
  found.reserve(names.size());
  for (const std::string& name : names) {
    ProfileResult result = load_profile(name, folders);
    if (!result.loaded || result.loaded->profile.driver != DeviceDriver::kPid) continue;
    found.push_back(std::move(result.loaded->message));
  }
  return found;
}

std::string hex_id(std::uint16_t id) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "0x%04x", unsigned{id});
  return text.data();
}

std::string what_to_write(const HidrawNode& node, const pid::PidLayout& layout) {
  const pid::BitField& x = layout.input.x;
  return "Copy the profile openffboard.textproto and write into it matches { vendor_id: " +
         hex_id(node.vendor_id) + " product_id: " + hex_id(node.product_id) +
         " }, as position_scale the metres that its handle moves along x divided by " +
         std::to_string(x.maximum - x.minimum) +
         ", and as force_scale the newtons that it gives at most divided by " +
         std::to_string(layout.constant.magnitude.maximum) +
         "; then name the file as the profile of the device in --config";
}

void tell_of_others(const HidrawNode& node) {
  std::string inputs;
  for (const std::string& input : force_inputs(node)) inputs += " " + input;
  if (inputs.empty()) return;
  spdlog::warn(
      "{}: the kernel's hid-pidff lets other programs push with it too. While hapticd runs, let no "
      "game, Wine, Steam or fftest use it, or take it from them: sudo chmod 600{}",
      describe(node), inputs);
}

KeptDriver kept(pid::PidDevice& device, const HidrawNode& known, const pid::PidLayout& layout) {
  KeptDriver driver;
  driver.mine = is_pid;
  driver.attach = [&device, descriptor = known.descriptor, layout](const HidrawNode& node,
                                                                   const ReportChannel& channel) {
    if (node.descriptor != descriptor) {
      throw DeviceError(node, "it is a different device with the same serial as before",
                        "Restart hapticd to use it.");
    }
    const pid::StartResult started = start(layout, channel);
    if (!started.problem.empty()) throw DeviceError(node, started.problem, "Plug it in again.");
    tell_of_others(node);
    device.attach(channel, started.blocks);
  };
  driver.detach = [&device] { device.detach(); };
  driver.failed = [&device] { return device.failed(); };
  return driver;
}

}  // namespace

bool is_pid(const HidrawNode& node) {
  return pid::find_layout(node.descriptor).lack.empty() &&
         !is_profile_v1(hid::read_descriptor(node.descriptor));
}

v1::DeviceProfile pid_base(const HidrawNode& node, const v1::DeviceProfile& base,
                           std::span<const v1::DeviceProfile> installed) {
  if (base.name() != kGenericPid) return base;
  const v1::DeviceProfile* best = &base;
  int most = 0;
  for (const v1::DeviceProfile& profile : installed) {
    for (const v1::DeviceMatch& match : profile.matches()) {
      const int numbers = fitting(match, node);
      if (numbers <= most) continue;
      most = numbers;
      best = &profile;
    }
  }
  return *best;
}

v1::DeviceProfile pid_profile(const HidrawNode& node, const pid::PidLayout& layout,
                              const v1::DeviceProfile& base) {
  const v1::AxisMap& axes = base.axis_map();
  if (axes.force_scale().value_size() == 0 || axes.position_scale().value_size() == 0) {
    throw DeviceError(node, "no profile says what a unit of its position and force is",
                      what_to_write(node, layout) + ".");
  }
  v1::DeviceProfile profile = base;
  profile.set_driver(v1::DRIVER_PID);
  profile.clear_watchdog_s();
  if (profile.description().empty()) profile.set_description(describe(node));
  profile.set_description(profile.description() + "; no device watchdog: 1 N at most");
  limit(profile, "peak_force_n", kUnwatchedForce, "there is no device watchdog");
  return profile;
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

OutsideDevice attach_pid(const std::string& serial, const v1::DeviceProfile& base, double max_force,
                         const fs::path& checks) {
  const HidrawNode node = find_node(is_pid, serial, "pid");
  const pid::PidLayout layout = pid::find_layout(node.descriptor).layout;
  const std::vector<v1::DeviceProfile> installed = installed_pid_profiles();
  v1::DeviceProfile profile = pid_profile(node, layout, pid_base(node, base, installed));
  OutsideDevice outside;
  outside.check =
      check_of(node, node.descriptor, {true, true, false}, profile_to_check(profile), checks);
  if (!outside.check->passed()) {
    limit(profile, "peak_force_n", kUncheckedForce, "nobody has checked its axes and signs");
  }
  outside.profile = checked(profile);
  const DeviceProfile& numbers = outside.profile.profile;
  spdlog::warn(
      "{}: experimental. There is no device watchdog: if hapticd dies while it pushes, it "
      "pushes on. Force limited to {} N; never more than {} N",
      describe(node), std::min(max_force, numbers.peak_force), kUnwatchedForce);
  auto device = std::make_unique<pid::PidDevice>(
      numbers, pid::PidSettings{outside.profile.axes, layout}, now);
  outside.keeper = std::make_unique<DeviceKeeper>(kept(*device, node, layout), node,
                                                  std::make_unique<HidrawHandles>(node));
  outside.device = std::move(device);
  return outside;
}

}  // namespace hapticd
