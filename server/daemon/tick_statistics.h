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
  /// Fills in SECTION_TIMING, with stages where asked for. Cost: microseconds; percentiles are
  /// renewed every 64 ticks.
  void fill(const Tick& tick, bool stages, v1::Timing& timing);

 private:
  struct Part {
    LatencyHistogram histogram;
    LatencySummary summary;
    std::uint32_t last_ns = 0;
  };
  static constexpr std::size_t kParts = 6;
  static constexpr std::array<v1::Stage, kParts> kStages{v1::STAGE_UNSPECIFIED, v1::STAGE_READ,
                                                         v1::STAGE_SIMULATION,  v1::STAGE_SAFETY,
                                                         v1::STAGE_WRITE,       v1::STAGE_PUBLISH};
  std::array<Part, kParts> parts_{};  ///< [0]: the whole tick
  std::uint32_t scene_id_ = 0;
  std::uint64_t count_ = 0;
  std::uint64_t summarised_ = 0;
};

}  // namespace hapticd
