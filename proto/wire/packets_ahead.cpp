// See packets_ahead.h.
#include "proto/wire/packets_ahead.h"

namespace hapticd::wire {
namespace {

/// Share of a new round trip in the mean: less, and a road that has become slower is believed late;
/// more, and one late acknowledgement holds repeats up.
constexpr std::int64_t kShareOfNew = 8;
/// The same of what came after a repeat, and may have been faster: less, and a road that has become
/// much slower is believed late; more, and where much is lost repeats come late.
constexpr std::int64_t kShareOfDoubtful = 64;

}  // namespace

// One Packet costs little and is repeated as without all this; several when they are late.
std::int64_t PacketsAhead::wait_ns() const noexcept {
  std::int64_t pause_ns = kRepeat_ns;
  if (turns_ < kRepeats_ns.size()) {
    pause_ns = kRepeats_ns[turns_] - (turns_ == 0 ? 0 : kRepeats_ns[turns_ - 1]);
  }
  return width_ == 1 ? pause_ns : 2 * round_trip_ns_ + pause_ns;
}

// A Packet was acknowledged: one more at a time, or later one more for all of them.
void PacketsAhead::widen() noexcept {
  if (++borne_ < (steep_ ? 1 : width_)) return;
  borne_ = 0;
  width_ = std::min(width_ + 1, kMaxAhead);
}

void PacketsAhead::left(std::uint64_t first, std::uint64_t last, std::int64_t now_ns) noexcept {
  const bool anew = first == acknowledged_ + 1;
  if (anew) count_ = 0;
  if (count_ < last_ids_.size()) ++count_;
  last_ids_[(oldest_ + count_ - 1) % last_ids_.size()] = last;
  next_id_ = last + 1;
  if (last > highest_ && timed_id_ == 0) {
    timed_id_ = last;
    timed_ns_ = now_ns;
  }
  highest_ = std::max(highest_, last);
  if (due_ns_ == kNever_ns) moved_ns_ = now_ns;
  if (anew || due_ns_ == kNever_ns) due_ns_ = now_ns + wait_ns();
}

void PacketsAhead::acknowledged(std::uint64_t id, std::int64_t now_ns) noexcept {
  while (count_ > 0 && last_ids_[oldest_] <= id) {
    oldest_ = (oldest_ + 1) % last_ids_.size();
    --count_;
    widen();
  }
  learn_round_trip(id, now_ns);
  acknowledged_ = id;
  moved_ns_ = now_ns;
  next_id_ = std::max(next_id_, id + 1);
  turns_ = 0;
  due_ns_ = id == highest_ ? kNever_ns : now_ns + wait_ns();
}

// Of what has left twice nobody knows which one is acknowledged (Karn and Partridge, "Improving
// round-trip time estimates in reliable transport protocols", SIGCOMM 1987).
void PacketsAhead::learn_round_trip(std::uint64_t id, std::int64_t now_ns) noexcept {
  const bool timed = timed_id_ != 0 && timed_id_ <= id;
  if (!timed && turns_ == 0) return;
  const std::int64_t taken_ns = std::min(now_ns - (timed ? timed_ns_ : moved_ns_), kRepeat_ns);
  const std::int64_t share = timed ? kShareOfNew : kShareOfDoubtful;
  round_trip_ns_ += acknowledged_ == 0 ? taken_ns : (taken_ns - round_trip_ns_) / share;
  if (timed) timed_id_ = 0;
}

void PacketsAhead::turn_back(std::int64_t now_ns) noexcept {
  count_ = 0;
  next_id_ = acknowledged_ + 1;
  steep_ = steep_ && width_ == 1;
  width_ = turns_ == 0 ? std::max(width_ / 2, 1U) : 1;
  borne_ = 0;
  ++turns_;
  timed_id_ = 0;
  due_ns_ = now_ns + wait_ns();
}

}  // namespace hapticd::wire
