// The daemon's side of the haptic loop: numbers the commands, lends the loop what they need and
// takes it back, answers requests when the loop has obeyed, and knows where the loop is. Under
// virtual time the loop obeys at once, since a tick may be long in coming. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/daemon/served_clients.h"
#include "server/haptic_loop/haptic_loop.h"

namespace hapticd {

class LoopDesk {
 public:
  /// `stepped_here`: the loop has no thread of its own. `clients` outlives this.
  LoopDesk(ServedClients& clients, bool stepped_here);

  /// Makes the loop, which plays `first`. `on_event` hears of all that it tells, in order, before
  /// requests are answered and what is given back is freed.
  void begin(const LoopOptions& options, std::unique_ptr<PlayedScene> first,
             std::function<void(const LoopEvent&)> on_event);
  [[nodiscard]] HapticLoop& loop() noexcept { return *loop_; }
  [[nodiscard]] LoopChannels& channels() noexcept { return *channels_; }

  /// The number of the next command.
  [[nodiscard]] std::uint64_t next_number() const noexcept { return last_number_ + 1; }
  /// The loop is to do this for a request, which is answered when it has; or at once, BUSY.
  [[nodiscard]] Answer command(const RequestId& id, const LoopCommandBody& what);
  /// The same without a request; false when the loop has no room.
  bool post(const LoopCommandBody& what);
  /// Lends a gesture, a change of settings, the next scene, for a request or for none; BUSY when
  /// the loop has no room.
  [[nodiscard]] Answer lend(const RequestId& id, std::unique_ptr<GesturePlan> plan);
  [[nodiscard]] Answer lend(const std::optional<RequestId>& id,
                            std::unique_ptr<SettingsChange> change);
  /// `told` is the message of the answer, once the scene plays.
  [[nodiscard]] Answer lend(const std::optional<RequestId>& id, std::unique_ptr<PlayedScene> scene,
                            std::string told);
  /// What waits is obeyed now, where no thread does it.
  void obey();

  /// Takes what the loop has told: answers requests whose command is over, and frees what is given
  /// back.
  void take_events();

  /// Another lease has ended: its poses and waiting changes are to be forgotten.
  void lose_lease();
  /// Tells the loop of leases that have ended, if it had no room before.
  void tell_lease_ends();
  /// Leases that have ended.
  [[nodiscard]] std::uint64_t lease_ends() const noexcept { return lease_ends_; }
  /// The loop has heard of them all, or never will.
  [[nodiscard]] bool knows_lease_ends() const noexcept;
  /// The loop is to ramp its force down and to do nothing more after that.
  void end();

  /// A tick is over.
  void note(const Tick& tick) noexcept;
  /// As of the newest tick known here.
  [[nodiscard]] LoopState state() const noexcept { return state_; }
  /// The tick that runs next; of a loop with a thread of its own the one after the newest known.
  [[nodiscard]] std::uint64_t next_tick() const noexcept;

 private:
  /// A request whose command is not yet obeyed.
  struct Waiting {
    std::uint64_t number;
    RequestId id;
    std::string told;  ///< the message of the answer, if it is obeyed
  };

  template <typename Lend>
  [[nodiscard]] Answer lend(const std::optional<RequestId>& id, const LoopCommandBody& what,
                            const Lend& lend_thing);
  [[nodiscard]] bool has_room() const noexcept;
  [[nodiscard]] Answer refuse();
  /// `make_result(told)` is the result of the request whose command this was, if any.
  template <typename MakeResult>
  void finish(std::uint64_t number, MakeResult&& make_result);
  void follow();
  void settle(const LoopEvent& event);
  void take_back() noexcept;

  ServedClients& clients_;
  bool stepped_here_;
  std::unique_ptr<LoopChannels> channels_;
  std::unique_ptr<HapticLoop> loop_;
  std::function<void(const LoopEvent&)> on_event_;
  std::deque<Waiting> waiting_;  ///< by number
  std::uint64_t last_number_ = 0;
  // With the loop, or on their way there or back.
  std::size_t scenes_lent_ = 1;  ///< the first one
  std::size_t gestures_lent_ = 0;
  std::size_t changes_lent_ = 0;
  std::uint64_t lease_ends_ = 0;
  std::uint64_t told_lease_ends_ = 0;
  std::uint64_t lease_end_number_ = 0;  ///< of the command not obeyed yet that told; 0: none
  bool ending_ = false;
  LoopState state_ = LoopState::kDetached;
  std::uint64_t newest_tick_ = 0;
};

}  // namespace hapticd
