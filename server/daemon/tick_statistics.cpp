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
  const std::array<std::uint32_t, kParts> spans{times.cpu_ns,   times.read_ns,  times.simulate_ns,
                                                times.limit_ns, times.write_ns, times.publish_ns};
  for (std::size_t k = 0; k < kParts; ++k) {
    parts_[k].last_ns = spans[k];
    // The first tick knows nothing of a tick before it.
    if (spans[k] > 0) record(parts_[k].histogram, spans[k]);
  }
  ++count_;
}

void TickStatistics::fill(const Tick& tick, bool stages, v1::Timing& timing) {
  if (count_ >= summarised_ + kRenewal || summarised_ == 0) {
    for (Part& part : parts_) part.summary = summarise(part.histogram);
    summarised_ = count_;
  }
  const auto narrow = [](std::int64_t ns) { return static_cast<std::uint32_t>(ns); };
  const Part& all = parts_[0];
  timing.set_last_ns(all.last_ns);
  timing.set_p50_ns(narrow(all.summary.p50_ns));
  timing.set_p99_ns(narrow(all.summary.p99_ns));
  timing.set_p999_ns(narrow(all.summary.p99_9_ns));
  timing.set_max_ns(narrow(all.summary.max_ns));
  timing.set_overruns(tick.times.overruns);
  std::int64_t oldest_ns = 0;
  for (const ToolTick& tool : tick.tools) {
    oldest_ns = std::max(oldest_ns, tick.t_ns - tool.sample.t_ns);
  }
  timing.set_input_age_ns(narrow(oldest_ns));
  for (std::size_t k = 1; stages && k < kParts; ++k) {
    v1::StageTiming& stage = *timing.add_stages();
    stage.set_stage(kStages[k]);
    stage.set_last_ns(parts_[k].last_ns);
    stage.set_p50_ns(narrow(parts_[k].summary.p50_ns));
    stage.set_p99_ns(narrow(parts_[k].summary.p99_ns));
    stage.set_p999_ns(narrow(parts_[k].summary.p99_9_ns));
    stage.set_max_ns(narrow(parts_[k].summary.max_ns));
  }
}

}  // namespace hapticd
