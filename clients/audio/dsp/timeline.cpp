// See timeline.h.
#include "clients/audio/dsp/timeline.h"

#include <algorithm>

namespace hapticd::audio {
namespace {

/// The frame nearest to an instant; a frame beyond 2^62 ns is as good as never.
std::int64_t frame_at(const FrameClock& clock, std::int64_t due_ns) noexcept {
  const double frames = static_cast<double>(due_ns - clock.heard_ns) / clock.ns_per_frame;
  constexpr double kFar = 4e18;
  const double bounded = std::clamp(frames, -kFar, kFar);
  // Halves go up, on both sides of 0: the frame must not depend on which one the clock names.
  auto whole = static_cast<std::int64_t>(bounded);
  if (static_cast<double>(whole) > bounded) --whole;
  if (bounded - static_cast<double>(whole) >= 0.5) ++whole;
  return clock.frame + whole;
}

}  // namespace

void Timeline::add(const Order& order) noexcept {
  const auto place = freed_ > 0 ? free_[--freed_] : static_cast<std::uint16_t>(used_++);
  orders_[place] = order;
  // Insertion from the end, where what is due first is: an order seldom overtakes many.
  std::size_t at = waiting_++;
  std::size_t begin = 0;
  while (begin < at && orders_[queue_[begin]].due_ns > order.due_ns) ++begin;
  for (; at > begin; --at) queue_[at] = queue_[at - 1];
  queue_[begin] = place;
}

void Timeline::play(const Order& order, std::int64_t late_frames, double ns_per_frame,
                    std::int32_t offset, MidiEvents& notes) noexcept {
  if (order.kind == Order::Kind::kChange) {
    synthesizer_.change(order.change);
    if (order.change.keep < 1.0) notes_.end(order.change.string, offset, notes);
    return;
  }
  if (order.kind == Order::Kind::kTelling) {
    if (order.telling.ends_note) notes_.end(order.strike.string, offset, notes);
    if (!synthesizer_.tell(order.strike, order.telling)) return;
  } else {
    synthesizer_.start(order.strike);
  }
  notes_.begin(order.strike, offset, notes);
  counts_.played.fetch_add(1, std::memory_order_relaxed);
  counts_.stolen.store(synthesizer_.stolen(), std::memory_order_relaxed);
  if (late_frames <= 0) return;
  counts_.late.fetch_add(1, std::memory_order_relaxed);
  const auto late_ns = static_cast<std::int64_t>(static_cast<double>(late_frames) * ns_per_frame);
  if (late_ns > counts_.latest_ns.load(std::memory_order_relaxed)) {
    counts_.latest_ns.store(late_ns, std::memory_order_relaxed);
  }
}

void Timeline::render(const FrameClock& clock, std::int64_t first_frame, std::span<float> out,
                      MidiEvents& notes) noexcept {
  notes.count = 0;
  const auto size = static_cast<std::int64_t>(out.size());
  std::int64_t done = 0;
  while (waiting_ > 0) {
    const std::uint16_t place = queue_[waiting_ - 1];
    const std::int64_t at = frame_at(clock, orders_[place].due_ns) - first_frame;
    if (at >= size) break;
    const std::int64_t begin = std::max(at, done);
    synthesizer_.render(
        out.subspan(static_cast<std::size_t>(done), static_cast<std::size_t>(begin - done)));
    done = begin;
    play(orders_[place], at < 0 ? -at : 0, clock.ns_per_frame, static_cast<std::int32_t>(begin),
         notes);
    --waiting_;
    free_[freed_++] = place;
  }
  synthesizer_.render(out.subspan(static_cast<std::size_t>(done)));
  notes_.advance(static_cast<std::int32_t>(size), notes);
  counts_.broken.store(synthesizer_.broken(), std::memory_order_relaxed);
  counts_.limited.store(synthesizer_.limited(), std::memory_order_relaxed);
}

}  // namespace hapticd::audio
