// What reaches the loop from outside beside samples, scenes and settings: what a command asks of
// the state machine, the window in which a Clear waits for a device, and the lease of whoever gives
// the poses. RT: yes.
#pragma once

#include <cstdint>
#include <limits>
#include <utility>

#include "core/tick/tick.h"
#include "server/haptic_loop/loop_command.h"

namespace hapticd {

/// How long a Clear waits for a device to forget its fault, ns: many of its frames.
inline constexpr std::int64_t kClearWait_ns = 100'000'000;

class Orders {
 public:
  /// Notes a command that the state machine hears, at `t_ns`. Of Stop and Clear the later counts,
  /// also where one tick hears both.
  void ask(const LoopCommandBody& what, std::int64_t t_ns) noexcept {
    const unsigned order = order_of(what);
    if (order == kOrderStop) {
      asked_ &= ~unsigned{kOrderClear};
      clear_until_ns_ = kNever;
    }
    if (order == kOrderClear) clear_until_ns_ = t_ns + kClearWait_ns;
    asked_ |= order;
  }

  /// The lease is over, the `ended`th; `follows`: a device follows poses, and is without any now.
  void lose_lease(std::uint64_t ended, bool follows) noexcept {
    leases_ended_ = ended;
    lease_lost_ = lease_lost_ || follows;
  }
  /// A pose of a holder after so many leases has come: true when that lease still holds.
  [[nodiscard]] bool take_pose(std::uint64_t lease) noexcept {
    if (lease < leases_ended_) return false;
    lease_lost_ = false;
    return true;
  }

  /// A Clear waits for a device to forget its fault.
  [[nodiscard]] bool clears(std::int64_t t_ns) const noexcept { return clear_until_ns_ > t_ns; }

  /// The orders of the tick that begins after `t_ns` (OrderBit), and none of them again. `fault`:
  /// one is latched; without one no Clear waits, but for the Stop of this tick.
  [[nodiscard]] unsigned gather(std::int64_t t_ns, bool fault) noexcept {
    if (!fault && (asked_ & kOrderStop) == 0) clear_until_ns_ = kNever;
    unsigned orders = std::exchange(asked_, 0U);
    if (lease_lost_) orders |= kOrderLeaseLost;
    if (clears(t_ns)) orders |= kOrderClear;
    return orders;
  }

 private:
  /// The order that a command is, for those that the state machine hears.
  [[nodiscard]] static std::uint16_t order_of(const LoopCommandBody& what) noexcept {
    if (std::holds_alternative<EngageCommand>(what)) return kOrderEngage;
    if (std::holds_alternative<DisengageCommand>(what)) return kOrderDisengage;
    if (std::holds_alternative<StopCommand>(what)) return kOrderStop;
    if (std::holds_alternative<ClearCommand>(what)) return kOrderClear;
    if (std::holds_alternative<EndCommand>(what)) return kOrderEnd;
    return 0;
  }

  /// Before every instant.
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

  unsigned asked_ = 0;  ///< OrderBit, by commands since the last tick
  std::int64_t clear_until_ns_ = kNever;
  std::uint64_t leases_ended_ = 0;
  bool lease_lost_ = false;
};

}  // namespace hapticd
