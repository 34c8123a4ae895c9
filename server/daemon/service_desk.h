// What the service manager, the journal and the local network hear of the daemon as a whole. Not
// RT.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/daemon/daemon_plan.h"
#include "server/daemon/scene_desk.h"
#include "server/network/udp_transport.h"
#include "server/service/announcement.h"
#include "server/service/service_notifier.h"

namespace hapticd {

class ServiceDesk {
 public:
  /// `stepped_here`: the loop has no thread of its own. The others outlive this.
  ServiceDesk(const DaemonPlan& plan, const SceneDesk& scenes, bool stepped_here);

  /// The first scene is there.
  void begin();
  /// Publishes the socket by mDNS. Throws StartError where it is bound to one address: mDNS
  /// tells of all that the machine has.
  void announce(const UdpTransport& transport);
  /// A tick is over.
  void note(const Tick& tick) noexcept;
  /// A pass of the main thread is over: says what has changed, and that the daemon is alive.
  ///
  /// A loop with a thread of its own is alive while it ticks. One that is stepped here may rightly
  /// wait for its client for ever: then this thread's passes count.
  void follow(std::int64_t now_ns);
  /// The configuration is about to be read anew.
  void reload() { notifier_.reloading(); }
  /// The daemon ends.
  void end();

 private:
  void keep_scene();
  void tell_shortages(std::int64_t now_ns);
  [[nodiscard]] std::string status() const;

  const DaemonPlan& plan_;
  const SceneDesk& scenes_;
  bool stepped_here_;
  ServiceNotifier notifier_;
  std::unique_ptr<Announcement> announcement_;  ///< null: not announced
  std::uint64_t ticks_ = 0;                     ///< taken from the loop
  std::uint64_t passes_ = 0;
  LoopState state_ = LoopState::kDetached;
  std::string scene_;  ///< as told
  LoopState told_state_{};
  std::uint64_t told_shortages_ = 0;
  std::int64_t shortages_due_ns_ = 0;
};

}  // namespace hapticd
