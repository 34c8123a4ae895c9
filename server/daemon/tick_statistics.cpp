// See tick_statistics.h.
#include "server/daemon/tick_statistics.h"

namespace hapticd {
namespace {

/// Ticks between two renewals of the percentiles: a summary walks 15 kB per part.
constexpr std::uint64_t kRenewal = 64;

}  // namespace

void TickStatistics::add(const Tick& tick) {
  if (tick.scene_id != scene_id_) {
    *this = TickStatistics{};
    scene_id_ = tick.scene_id;
  }
  const TimesTick& times = tick.times;
  // The first tick knows nothing of a tick before it.
  const auto take = [&](std::size_t part, std::uint32_t time_ns) {
    if (time_ns > 0) record(parts_[part].histogram, time_ns);
  };
  take(0, times.cpu_ns);
  for (std::size_t k = 0; k < kStages; ++k) take(k + 1, times.stages[k]);
  take(v1::STAGE_SIMULATION, simulation_ns(times.stages));
  ++count_;
}

void TickStatistics::fill(const Tick& tick, v1::Timing& timing) {
  if (count_ >= summarised_ + kRenewal || summarised_ == 0) {
    for (Part& part : parts_) part.summary = summarise(part.histogram);
    summarised_ = count_;
  }
  const auto narrow = [](std::int64_t ns) { return static_cast<std::uint32_t>(ns); };
  const auto put = [&](const LatencySummary& summary, auto& out) {
    out.set_p50_ns(narrow(summary.p50_ns));
    out.set_p99_ns(narrow(summary.p99_ns));
    out.set_p999_ns(narrow(summary.p99_9_ns));
    out.set_max_ns(narrow(summary.max_ns));
  };
  timing.set_last_ns(tick.times.cpu_ns);
  put(parts_[0].summary, timing);
  timing.set_overruns(tick.times.overruns);
  std::int64_t oldest_ns = 0;
  for (const ToolTick& tool : tick.tools) {
    oldest_ns = std::max(oldest_ns, tick.t_ns - tool.sample.t_ns);
  }
  timing.set_input_age_ns(narrow(oldest_ns));
  for (v1::StageTiming& stage : *timing.mutable_stages()) {
    put(parts_[static_cast<std::size_t>(stage.stage())].summary, stage);
  }
}

}  // namespace hapticd
