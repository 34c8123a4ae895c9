// How long ticks took, gathered on the network thread: percentiles for State, since
// the scene was loaded. Not RT.
#pragma once

#include "core/rt/latency_histogram.h"
#include "core/tick/tick.h"
#include "hapticd/v1/state.pb.h"

namespace hapticd {

class TickStatistics {
 public:
  /// Takes a tick's times in; those of another scene begin anew.
  void add(const Tick& tick);
  /// Fills in SECTION_TIMING, and the percentiles of the stages that `timing` has. Cost:
  /// microseconds; percentiles are renewed every 64 ticks.
  void fill(const Tick& tick, v1::Timing& timing);

 private:
  struct Part {
    LatencyHistogram histogram;
    LatencySummary summary;
  };
  std::array<Part, v1::Stage_ARRAYSIZE> parts_{};  ///< by v1::Stage; [0]: the whole tick
  std::uint32_t scene_id_ = 0;
  std::uint64_t count_ = 0;
  std::uint64_t summarised_ = 0;
};

}  // namespace hapticd
