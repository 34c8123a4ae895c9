// Reports of a device without a clock as a loop reads them: the device makes one per interval, some
// are lost, some wait in the system, the device pauses; ticks come late and all that waits is read
// at once. Truth for estimates, from the readings, of when a report was made.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "tests/support/random.h"

namespace hapticd::test {

/// What goes wrong, all of it in ns and shares.
struct ReadingTrouble {
  std::int64_t interval_ns = 1'000'000;  ///< from one report to the next
  std::int64_t tick_ns = 1'000'000;
  double late = 0.1;                ///< share of ticks that come late by up to 0.95 of one
  double lost = 0.0;                ///< share of reports that are lost, never two in four
  double pause = 0.0;               ///< share of reports that a pause of 5 to 50 follows
  double stall = 0.0;               ///< share of ticks at whose start nothing arrives for up to 5
  std::int64_t jitter_ns = 20'000;  ///< of ticks that are in time
};

/// One tick: when it read, and when what it read was made, oldest first, by a clock that stands
/// still in pauses, as the hand does.
struct Reading {
  std::int64_t now_ns = 0;
  std::vector<std::int64_t> made_ns;
};

class LateReadings {
 public:
  LateReadings(const ReadingTrouble& trouble, std::uint64_t seed)
      : trouble_(trouble), random_(seed) {
    next_report_ns_ = begin_ns_ + below(trouble.interval_ns);
  }

  Reading next() {
    const std::int64_t due_ns = begin_ns_ + ++ticks_ * trouble_.tick_ns;
    const bool late = random_.chance(trouble_.late);
    const std::int64_t most_ns = late ? trouble_.tick_ns / 100 * 95 : trouble_.jitter_ns;
    now_ns_ = std::max(now_ns_ + 10'000, due_ns + below(most_ns));
    if (random_.chance(trouble_.stall)) {
      stalled_until_ns_ = now_ns_ + below(5 * trouble_.tick_ns);
    }
    while (next_report_ns_ <= now_ns_) make_report();
    Reading reading{now_ns_, {}};
    while (!queue_.empty() && now_ns_ >= stalled_until_ns_) {
      reading.made_ns.push_back(queue_.front());
      queue_.pop_front();
    }
    return reading;
  }

 private:
  std::int64_t below(std::int64_t most) {
    return static_cast<std::int64_t>(random_.below(static_cast<std::uint64_t>(most) + 1));
  }

  void make_report() {
    const bool lost = since_lost_ >= 3 && random_.chance(trouble_.lost);
    since_lost_ = lost ? 0 : since_lost_ + 1;
    if (!lost) queue_.push_back(next_report_ns_ - paused_ns_);
    next_report_ns_ += trouble_.interval_ns;
    if (random_.chance(trouble_.pause)) {
      const std::int64_t pause_ns = (5 + below(45)) * trouble_.interval_ns;
      next_report_ns_ += pause_ns;
      paused_ns_ += pause_ns;
    }
  }

  ReadingTrouble trouble_;
  SplitMix64 random_;
  std::int64_t begin_ns_ = 7'000'000'000;
  std::int64_t now_ns_ = 0;
  std::int64_t ticks_ = 0;
  std::int64_t next_report_ns_ = 0;
  std::int64_t stalled_until_ns_ = 0;
  std::int64_t paused_ns_ = 0;
  int since_lost_ = 0;
  std::deque<std::int64_t> queue_;
};

}  // namespace hapticd::test
