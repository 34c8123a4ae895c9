// See service_notifier.h.
#include "server/service/service_notifier.h"

#include <systemd/sd-daemon.h>

namespace hapticd {
namespace {

/// How often the watchdog is fed in its time. Twice would do; four times outlasts a busy machine.
constexpr std::int64_t kFeedsPerTimeout = 4;

// What is not heard is not said again: the service manager has gone, or never was.
void tell(const std::string& state) { static_cast<void>(sd_notify(0, state.c_str())); }

}  // namespace

ServiceNotifier::ServiceNotifier() {
  std::uint64_t timeout_us = 0;
  if (sd_watchdog_enabled(1, &timeout_us) > 0) {
    feed_period_ns_ = static_cast<std::int64_t>(timeout_us) * 1000 / kFeedsPerTimeout;
  }
}

void ServiceNotifier::ready() {
  if (phase_ != Phase::kStarting && phase_ != Phase::kReloading) return;
  phase_ = Phase::kReady;
  tell("READY=1");
}

void ServiceNotifier::reloading() {
  if (phase_ != Phase::kReady) return;
  phase_ = Phase::kReloading;
  tell("RELOADING=1");
}

void ServiceNotifier::stopping() {
  if (phase_ == Phase::kStopping) return;
  phase_ = Phase::kStopping;
  tell("STOPPING=1");
}

void ServiceNotifier::status(const std::string& line) {
  if (line == status_) return;
  status_ = line;
  tell("STATUS=" + line);
}

void ServiceNotifier::alive(std::uint64_t progress, std::int64_t now_ns) {
  if (feed_period_ns_ == 0 || progress == fed_progress_) return;
  if (fed_progress_ && now_ns - fed_at_ns_ < feed_period_ns_) return;
  fed_progress_ = progress;
  fed_at_ns_ = now_ns;
  tell("WATCHDOG=1");
}

}  // namespace hapticd
