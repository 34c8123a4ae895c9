// What systemd is told of the daemon, by the protocol of sd_notify(3) through libsystemd: ready,
// reloading, stopping, a line of status, and that it is alive. Does nothing where no service
// manager has started the program. One thread. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace hapticd {

class ServiceNotifier {
 public:
  /// Reads $NOTIFY_SOCKET, $WATCHDOG_USEC and $WATCHDOG_PID, and takes the latter two out of the
  /// environment, so that no child inherits them.
  ServiceNotifier();

  /// The daemon serves. Also ends a reload. Repeated calls say it once.
  void ready();
  /// The configuration is read anew, until ready() is called.
  void reloading();
  /// The daemon ends.
  void stopping();
  /// One line for `systemctl status`; what has been said already is not repeated.
  void status(const std::string& line);
  /// Feeds the watchdog if `progress` has changed since it was last fed, and a quarter of its time
  /// is over at `now_ns`, on the monotonic clock. A daemon whose progress stands still is not fed
  /// and is killed by systemd once WatchdogSec is over.
  void alive(std::uint64_t progress, std::int64_t now_ns);

 private:
  enum class Phase { kStarting, kReady, kReloading, kStopping };

  Phase phase_ = Phase::kStarting;
  std::string status_;
  std::int64_t feed_period_ns_ = 0;  ///< 0: there is no watchdog
  std::int64_t fed_at_ns_ = 0;
  std::optional<std::uint64_t> fed_progress_;
};

}  // namespace hapticd
