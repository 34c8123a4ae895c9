// Between the thread that hears the daemon and the audio callback: a ring of orders, lossless until
// it is full, and the timeline that plays them. One thread submits, one renders.
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <span>

#include "clients/audio/dsp/timeline.h"

namespace hapticd::audio {

/// About 3 MB: on the heap.
class AudioEngine {
 public:
  /// `body`, and all orders, are made for `rate_hz`.
  explicit AudioEngine(const BodyFilter& body, double rate_hz = 48000.0) noexcept
      : rate_hz_(rate_hz), timeline_(body) {}

  /// Sample rate of what it renders, Hz.
  [[nodiscard]] double rate_hz() const noexcept { return rate_hz_; }

  /// An order to be played; false when the ring is full: it is lost, which the caller counts.
  [[nodiscard]] bool submit(const Order& order) { return ring_.push(order); }
  /// RT: for the audio callback. The frames from `first_frame` on.
  void render(const FrameClock& clock, std::int64_t first_frame, std::span<float> out,
              MidiEvents& notes) noexcept;
  /// What has been played; from any thread.
  [[nodiscard]] const PlayCounts& counts() const noexcept { return timeline_.counts(); }

 private:
  static constexpr std::size_t kRing = 1024;

  double rate_hz_;
  boost::lockfree::spsc_queue<Order, boost::lockfree::capacity<kRing>> ring_;
  Order taken_;  ///< by the callback, out of the ring
  Timeline timeline_;
};

}  // namespace hapticd::audio
