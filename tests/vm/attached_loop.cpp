// See attached_loop.h.
#include "tests/vm/attached_loop.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "core/rt/monotonic_clock.h"
#include "device/hid/device_features.h"
#include "device/hid/profile_units.h"
#include "device/hid/report_descriptor.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;

/// The longest a run waits for a sample to begin after.
constexpr std::int64_t kMaxFrame_ns = 2'000'000;
constexpr std::int64_t kLook_ns = 20'000;

std::int64_t now() noexcept { return monotonic_now_ns(); }

}  // namespace

void sleep_until(std::int64_t t_ns) {
  const timespec until{t_ns / 1'000'000'000, t_ns % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

void sleep_ms(int ms) { sleep_until(monotonic_now_ns() + ms * kTick_ns); }

std::vector<HidrawNode> find_devices() {
  std::vector<HidrawNode> found;
  for (HidrawNode& node : list_hidraw_nodes()) {
    if (is_profile_v1(hid::read_descriptor(node.descriptor))) found.push_back(std::move(node));
  }
  return found;
}

HidrawNode appears(const std::string& serial) {
  for (int k = 0; k < 200; ++k) {
    for (HidrawNode& node : find_devices()) {
      if (node.serial == serial) return std::move(node);
    }
    sleep_ms(10);
  }
  FAIL("no device " << serial);
  return {};
}

void disappears(const std::string& serial) {
  for (int k = 0; k < 200; ++k) {
    const std::vector<HidrawNode> found = find_devices();
    const auto is_it = [&](const HidrawNode& node) { return node.serial == serial; };
    if (std::none_of(found.begin(), found.end(), is_it)) return;
    sleep_ms(10);
  }
  FAIL("device " << serial << " stays");
}

AttachedLoop::AttachedLoop(const std::string& serial) {
  open(serial);
  begin(handles->channel());
}

void AttachedLoop::begin(const ReportChannel& channel) {
  std::string error;
  hid::Capabilities capabilities;
  REQUIRE(get_capabilities(channel, capabilities, error));
  hid::Config config = hid::to_config({}, capabilities);
  REQUIRE(agree(channel, config, error));
  DeviceProfile profile;
  profile.driver = DeviceDriver::kHid;
  hid::apply_capabilities(capabilities, profile);
  device.emplace(profile, capabilities, now);
  device->attach(channel);
}

void AttachedLoop::open(const std::string& serial) {
  node = appears(serial);
  handles.emplace(node);
}

void AttachedLoop::reopen(const std::string& serial) {
  device->detach();
  handles.reset();
  open(serial);
  device->attach(handles->channel());
}

ReadOutcome AttachedLoop::tick(double force, bool enable) {
  const std::int64_t begin_ns = monotonic_now_ns();
  outcome = device->read(begin_ns, sample);
  if (outcome == ReadOutcome::kFresh) {
    ++fresh;
    ages.push_back(monotonic_now_ns() - sample.t_ns);
  }
  DeviceCommand command;
  command.f_H_D = {0.0, force, 0.0};
  command.enable = enable;
  command.sample_counter = sample.counter;
  written = device->write(monotonic_now_ns(), command);
  if (outcome == ReadOutcome::kFresh) costs.push_back(monotonic_now_ns() - begin_ns);
  return outcome;
}

int AttachedLoop::run(int ticks, double force, bool enable) {
  int count = 0;
  std::int64_t due_ns = monotonic_now_ns();
  for (const std::int64_t end_ns = due_ns + kMaxFrame_ns; due_ns < end_ns;) {
    const bool heard = device->read(due_ns, sample) == ReadOutcome::kFresh;
    due_ns = monotonic_now_ns() + (heard ? kTick_ns / 2 : 0);
    if (heard) break;
    sleep_until(due_ns + kLook_ns);
  }
  for (int k = 0; k < ticks; ++k) {
    due_ns += kTick_ns;
    sleep_until(due_ns);
    if (tick(force, enable) == ReadOutcome::kFresh) ++count;
  }
  return count;
}

}  // namespace hapticd::test
