// The reference firmware behind a ReportChannel, as the system shows it to the driver: a queue that
// keeps the oldest 63 reports, and a plug. Time is the test's. Threads: the driver's writer and the
// test.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <vector>

#include "core/math/realtime.h"
#include "device/api/report_channel.h"
#include "tests/device/hid/firmware_bench.h"
#include "tests/device/hid/sent_reports.h"

namespace hapticd::test {

class PluggedBench {
 public:
  explicit PluggedBench(std::uint32_t caps = kHapHasVelocity) : bench(caps) {}

  [[nodiscard]] ReportChannel channel() {
    return {this, this, read, write, nullptr, nullptr, wait};
  }

  /// A frame: a servo cycle `later_us` after the last one, and its report.
  HapOutput frame(std::uint32_t later_us = 1000) {
    const std::lock_guard lock(mutex_);
    const HapOutput output = bench.servo(later_us);
    hap_sample(&bench.device);
    HapState state;
    if (hap_take_report(&bench.device, &state) && queue_.size() < 63) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&state);
      queue_.emplace_back(bytes, bytes + sizeof state);
    }
    return output;
  }
  /// Waits until the device has been given so many commands.
  void wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return commands_.size() >= count; });
  }
  [[nodiscard]] std::vector<hid::CommandReport> commands() {
    const std::lock_guard lock(mutex_);
    return commands_;
  }
  void set_plugged(bool plugged) {
    const std::lock_guard lock(mutex_);
    plugged_ = plugged;
    if (plugged) queue_.clear();
    hap_bus_reset(&bench.device);
  }
  /// Bytes that the device did not send.
  void inject(std::vector<std::uint8_t> bytes) {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(bytes));
  }

  /// What happens while somebody waits for a report; time does not pass by itself.
  std::function<void()> meanwhile;
  Bench bench;  ///< only between frames

 private:
  static int read(void* input, std::uint8_t* bytes, std::size_t room) noexcept {
    auto& self = *static_cast<PluggedBench*>(input);
    const std::lock_guard lock(self.mutex_);
    if (!self.plugged_) return -1;
    if (self.queue_.empty()) return 0;
    const std::size_t length = std::min(room, self.queue_.front().size());
    std::memcpy(bytes, self.queue_.front().data(), length);
    self.queue_.pop_front();
    return static_cast<int>(length);
  }
  static int write(void* output, const std::uint8_t* bytes, std::size_t length) noexcept {
    auto& self = *static_cast<PluggedBench*>(output);
    const std::lock_guard lock(self.mutex_);
    if (!self.plugged_) return -1;
    hid::CommandReport command;
    hid::AffineReport affine;
    if (decode_command({bytes, length}, command) == hid::Decoded::kOk) {
      self.commands_.push_back(command);
    } else if (decode_affine({bytes, length}, affine) == hid::Decoded::kOk) {
      self.commands_.push_back(affine.base);
    }
    hap_receive(&self.bench.device, self.bench.now_us, bytes, static_cast<std::uint32_t>(length));
    self.changed_.notify_all();
    return static_cast<int>(length);
  }

  static int wait(void* input, std::int64_t /*until_ns*/) noexcept {
    auto& self = *static_cast<PluggedBench*>(input);
    if (self.meanwhile) self.meanwhile();
    const std::lock_guard lock(self.mutex_);
    if (!self.plugged_) return -1;
    return self.queue_.empty() ? 0 : 1;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::vector<std::uint8_t>> queue_;
  std::vector<hid::CommandReport> commands_;
  bool plugged_ = true;
};

}  // namespace hapticd::test
