// Which States one session gets: its subscription, thinning out on loss or silence, and how far a
// Run of steps may be ahead of it. PROTOCOL.md, sections 3, 6 and 11. Pure. Not RT.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

#include "proto/wire/item_outbox.h"
#include "server/network/server_host.h"

namespace hapticd {

/// A session that was silent this long gets one State per kSlowPeriod_ns, ns.
inline constexpr std::int64_t kSlowAfter_ns = 3000 * wire::kMillisecond_ns;
inline constexpr std::int64_t kSlowPeriod_ns = 100 * wire::kMillisecond_ns;
/// What sounds is told again once in this time of the stream, ns.
inline constexpr std::int64_t kSoundingPeriod_ns = 100 * wire::kMillisecond_ns;
/// States a Run of steps may be ahead of what its session has reported as received.
inline constexpr std::uint64_t kMaxStatesAhead = 64;
/// Loss is judged over this time at least, ns, and over this many States.
inline constexpr std::int64_t kLossPeriod_ns = 1000 * wire::kMillisecond_ns;
inline constexpr std::uint64_t kLossStates = 10;
/// Share of States lost that doubles the divisor, and below which it is halved again.
inline constexpr double kMuchLoss = 0.10;
inline constexpr double kLittleLoss = 0.01;
/// The divisor is doubled so often at most: a subscriber of every tick still gets one in 1024.
inline constexpr std::uint32_t kMaxDoublings = 10;

/// The flow of States to one session.
class StateFlow {
 public:
  /// A Subscribe was carried out; what was known about loss is forgotten.
  void subscribe(const Subscription& subscription) {
    *this = StateFlow{};
    subscription_ = subscription;
  }

  [[nodiscard]] const Subscription& subscription() const noexcept { return subscription_; }
  /// The divisor in force, doublings included.
  [[nodiscard]] std::uint64_t divisor() const noexcept {
    return static_cast<std::uint64_t>(subscription_.divisor) << doublings_;
  }

  /// Whether the State of `tick` is to be sent now.
  [[nodiscard]] bool wants(std::uint64_t tick, std::int64_t silent_for_ns,
                           std::int64_t now_ns) const noexcept {
    if (subscription_.divisor == 0 || tick % divisor() != 0) return false;
    return silent_for_ns < kSlowAfter_ns || !any_sent_ || now_ns - sent_ns_ >= kSlowPeriod_ns;
  }

  /// What the State of `tick` is filled in for: the subscription, and whether it repeats what
  /// sounds. The first State of a subscription or scene does, and the first of each round of so
  /// many ticks, `round_ticks`, which begin together for all sessions; and each State after one
  /// that had no room for all of it goes on where that ended.
  [[nodiscard]] Subscription asked_at(std::uint64_t tick, std::uint32_t scene_id,
                                      std::uint64_t round_ticks) const noexcept {
    Subscription asked = subscription_;
    if (!asked.has(v1::SECTION_STRINGS)) return asked;
    const bool first = !any_sent_ || scene_id != scene_id_;
    if (!first && soundings_left_.has_value()) {
      asked.soundings_from = soundings_left_;
    } else if (first || tick / round_ticks != last_tick_ / round_ticks) {
      asked.soundings_from = 0;
    }
    return asked;
  }
  /// In the State that leaves now there was no room for what strings from this index on sound like.
  void left_out(std::optional<std::uint32_t> soundings_from) noexcept {
    soundings_left_ = soundings_from;
  }

  /// The State of `tick` leaves, in `datagrams` datagrams.
  void sent(std::uint64_t tick, std::uint32_t scene_id, std::uint64_t datagrams,
            std::int64_t now_ns) noexcept {
    if (!any_sent_ || scene_id != scene_id_) {
      // The first State of a scene: none of it has been received.
      scene_id_ = scene_id;
      base_tick_ = tick;
      any_received_ = false;
    }
    any_sent_ = true;
    last_tick_ = tick;
    count_ += datagrams;
    sent_ns_ = now_ns;
  }
  /// The newest State leaves once more, in this many datagrams.
  void repeated(std::uint64_t datagrams, std::int64_t now_ns) noexcept {
    count_ += datagrams;
    sent_ns_ = now_ns;
  }
  /// When the newest State left last; 0 = none did.
  [[nodiscard]] std::int64_t sent_ns() const noexcept { return sent_ns_; }

  /// What a Packet of the client says about States. `thin`: loss counts, so not in lockstep.
  void told(std::uint64_t seen, std::uint64_t newest, bool thin, std::int64_t now_ns) noexcept {
    // `newest` of a scene before this one may be larger than any tick of this one; it is smaller by
    // chance at worst, and then only delays.
    if (any_sent_ && newest >= base_tick_ && newest <= last_tick_ && seen > seen_at_first_) {
      received_tick_ = any_received_ ? std::max(received_tick_, newest) : newest;
      any_received_ = true;
    }
    if (thin && any_sent_) judge_loss(seen, now_ns);
    seen_at_first_ = any_sent_ ? seen_at_first_ : std::max(seen_at_first_, seen);
  }

  /// States that left and are newer than what the client has reported. Counted in steps of the
  /// subscribed divisor.
  [[nodiscard]] std::uint64_t ahead() const noexcept {
    if (!any_sent_ || subscription_.divisor == 0) return 0;
    if (any_received_) return (last_tick_ - received_tick_) / subscription_.divisor;
    return (last_tick_ - base_tick_) / subscription_.divisor + 1;
  }

 private:
  void judge_loss(std::uint64_t seen, std::int64_t now_ns) noexcept {
    if (!judging_) {
      judging_ = true;
      judged_ns_ = now_ns;
      judged_seen_ = seen;
      judged_count_ = count_;
      return;
    }
    const std::uint64_t left = count_ - judged_count_;
    if (now_ns - judged_ns_ < kLossPeriod_ns || left < kLossStates || seen < judged_seen_) return;
    const auto arrived = static_cast<double>(seen - judged_seen_);
    const double loss = 1.0 - arrived / static_cast<double>(left);
    if (loss > kMuchLoss && doublings_ < kMaxDoublings) ++doublings_;
    if (loss < kLittleLoss && doublings_ > 0) --doublings_;
    judged_ns_ = now_ns;
    judged_seen_ = seen;
    judged_count_ = count_;
  }

  Subscription subscription_;
  std::uint32_t doublings_ = 0;
  bool any_sent_ = false;
  std::uint32_t scene_id_ = 0;
  std::uint64_t base_tick_ = 0;
  std::uint64_t last_tick_ = 0;
  std::optional<std::uint32_t> soundings_left_;
  std::uint64_t count_ = 0;
  std::int64_t sent_ns_ = 0;
  bool any_received_ = false;
  std::uint64_t received_tick_ = 0;
  std::uint64_t seen_at_first_ = 0;
  bool judging_ = false;
  std::int64_t judged_ns_ = 0;
  std::uint64_t judged_seen_ = 0;
  std::uint64_t judged_count_ = 0;
};

}  // namespace hapticd
