// See command_line.h.
#include "device/simulated/command_line.h"

#include <cmath>
#include <limits>

namespace hapticd {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

/// Nanoseconds of `seconds` >= 0, to the nearest; kNever where they do not fit.
std::int64_t nanoseconds(double seconds) noexcept {
  const double ns = std::floor(seconds * 1e9 + 0.5);
  return ns < 9e18 ? static_cast<std::int64_t>(ns) : kNever;
}

}  // namespace

CommandLine::CommandLine(double delay, double watchdog)
    : delay_ns_(nanoseconds(delay)),
      watchdog_ns_(nanoseconds(watchdog)),
      ring_(kCommandsOnTheWay),
      zero_ns_(std::numeric_limits<std::int64_t>::min()) {}

bool CommandLine::send(std::int64_t now_ns, const DeviceCommand& command) noexcept {
  if (count_ == ring_.size()) return false;
  ring_[(first_ + count_) % ring_.size()] = {command, now_ns};
  ++count_;
  return true;
}

void CommandLine::send_zero(std::int64_t now_ns) noexcept {
  std::int64_t known = zero_ns_.load(std::memory_order_relaxed);
  while (known < now_ns && !zero_ns_.compare_exchange_weak(known, now_ns, std::memory_order_release,
                                                           std::memory_order_relaxed)) {
  }
}

CommandInForce CommandLine::at(std::int64_t t_ns) noexcept {
  // The device lives `delay` in the past of the host.
  const std::int64_t host_ns = t_ns - delay_ns_;
  while (count_ > 0 && ring_[first_].sent_ns <= host_ns) {
    current_ = ring_[first_];
    any_ = true;
    first_ = (first_ + 1) % ring_.size();
    --count_;
  }
  CommandInForce in_force;
  if (!any_) return in_force;
  const std::int64_t zero_ns = zero_ns_.load(std::memory_order_acquire);
  const bool zeroed = current_.sent_ns <= zero_ns && zero_ns <= host_ns;
  in_force.enabled = current_.command.enable;
  in_force.sample_counter = current_.command.sample_counter;
  in_force.stale = host_ns - current_.sent_ns >= watchdog_ns_;
  if (zeroed || in_force.stale || !in_force.enabled || host_ns >= current_.command.expires_ns) {
    return in_force;
  }
  in_force.spring = current_.command.spring;
  in_force.F_H_D = {to_vector(current_.command.f_H_D), to_vector(current_.command.t_H_D)};
  return in_force;
}

}  // namespace hapticd
