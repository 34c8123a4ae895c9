// See service_desk.h.
#include "server/daemon/service_desk.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/rt/memory_boundary.h"
#include "hapticd/v1/state.pb.h"
#include "server/service/journal.h"

namespace hapticd {
namespace {

/// Of package hapticd.v1.
constexpr std::uint32_t kProtocol = 1;
/// Between two lines about want of memory, ns.
constexpr std::int64_t kShortagePeriod_ns = 1'000'000'000;

}  // namespace

ServiceDesk::ServiceDesk(const DaemonPlan& plan, const SceneDesk& scenes, bool stepped_here)
    : plan_(plan), scenes_(scenes), stepped_here_(stepped_here) {}

void ServiceDesk::begin() {
  keep_log_field("HAPTICD_DEVICE", plan_.options.config.device(0).source());
  keep_scene();
}

void ServiceDesk::keep_scene() {
  scene_ = scenes_.told().info.scene().name();
  keep_log_field("HAPTICD_SCENE", scene_);
}

void ServiceDesk::announce(const UdpTransport& transport) {
  if (!transport.wildcard()) {
    throw StartError(kExitUsage, "--announce: that tells of every address of this machine, and " +
                                     transport.local_address() +
                                     " is only one. Listen on all: --listen 0.0.0.0:47800.");
  }
  announcement_ =
      std::make_unique<Announcement>(Announced{transport.port(), kProtocol, transport.ipv4_only()});
}

void ServiceDesk::note(const Tick& tick) noexcept {
  ++ticks_;
  state_ = tick.state;
}

void ServiceDesk::follow(std::int64_t now_ns) {
  ++passes_;
  const bool serves = stepped_here_ || ticks_ > 0;
  if (!serves) return;
  const bool changed = scenes_.told().info.scene().name() != scene_;
  if (changed) keep_scene();
  if (changed || state_ != told_state_) {
    told_state_ = state_;
    notifier_.status(status());
  }
  if (!scenes_.loading()) notifier_.ready();
  notifier_.alive(stepped_here_ ? passes_ : ticks_, now_ns);
  tell_shortages(now_ns);
}

void ServiceDesk::tell_shortages(std::int64_t now_ns) {
  const std::uint64_t all = shortages_of_memory.load(std::memory_order_relaxed);
  if (all == told_shortages_ || now_ns < shortages_due_ns_) return;
  shortages_due_ns_ = now_ns + kShortagePeriod_ns;
  spdlog::error("memory is short: {} pieces of work were left undone", all - told_shortages_);
  told_shortages_ = all;
}

void ServiceDesk::end() {
  notifier_.stopping();
  if (announcement_ != nullptr) announcement_->withdraw();
}

std::string ServiceDesk::status() const {
  const v1::Config& config = plan_.options.config;
  std::string state = v1::LoopState_Name(static_cast<v1::LoopState>(state_));
  state.erase(0, std::string_view("LOOP_STATE_").size());
  const std::string time =
      stepped_here_ ? "in virtual time" : fmt::format("at {} Hz", config.rate());
  return fmt::format("plays {} {}, device {}, {}", scene_, time, config.device(0).source(), state);
}

}  // namespace hapticd
