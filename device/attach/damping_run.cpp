// See damping_run.h.
#include "device/attach/damping_run.h"

#include <algorithm>

#include "core/math/vector.h"
#include "core/tick/measuring_plan.h"

namespace hapticd {
namespace {

/// A wrench may be later than the delay that is reckoned with by so many ticks.
constexpr int kLateTicks = 3;
/// Longer from tick to tick no force is held, s: devices let it go after 5 ms.
constexpr double kMaxHold_s = 4e-3;

}  // namespace

std::optional<RingVerdict> DampingRun::spoilt(const Tick& tick) const {
  const ToolTick& tool = tick.tools[tool_];
  constexpr unsigned kLimits = kSaturated | kThermalLimited | kPassivityLimited;
  const bool again = began_ && tool.asked.measure != 0;
  if (tick.state != LoopState::kEngaged || again || (began_ && tick.scene_id != scene_id_) ||
      (tool.flags & kClutched) != 0) {
    return RingVerdict::kCut;
  }
  const double hold_s = 1e-9 * static_cast<double>(tick.dt_ns);
  if (began_ && (tick.tick != next_ + tick.skipped || hold_s > kMaxHold_s + period_s_)) {
    return RingVerdict::kTicksLost;
  }
  if (!began_)
    return tool.asked.measure == axis_ ? std::nullopt : std::optional(RingVerdict::kTicksLost);
  if ((to_vector(tool.sample.p_DH) - to_vector(p_DH_)).norm() > kMaxExcursion) {
    return RingVerdict::kMoved;
  }
  if ((tool.flags & kLimits) != 0) return RingVerdict::kLimited;
  return std::nullopt;
}

std::optional<DampingFit> DampingRun::take(const Tick& tick) {
  if (tool_ >= tick.tools.size()) return DampingFit{RingVerdict::kCut, {}};
  if (!began_ && tick.tick < next_) return std::nullopt;
  if (const std::optional<RingVerdict> verdict = spoilt(tick)) return DampingFit{*verdict, {}};
  const ToolTick& tool = tick.tools[tool_];
  if (!began_) {
    began_ = true;
    scene_id_ = tick.scene_id;
    began_ns_ = tick.t_ns;
    p_DH_ = tool.sample.p_DH;
  } else if (samples_.size() == 1) {
    period_s_ = 1e-9 * static_cast<double>(tick.t_ns - began_ns_);
  }
  next_ = tick.tick + 1;
  const double age_s = 1e-9 * static_cast<double>(tick.t_ns - tool.sample.t_ns);
  delay_s_ = std::max(delay_s_, tool.stiffness.delay + std::clamp(age_s, 0.0, kMaxHold_s));
  const double t_s = 1e-9 * static_cast<double>(tick.t_ns - began_ns_);
  if (t_s >= kMeasuring_s) return fit_damping(samples_, delay_s_ + kLateTicks * period_s_);
  const auto along = static_cast<std::size_t>(place_of(axis_));
  samples_.push_back({t_s, tool.sample.p_DH[along], tool.f_written_H_D[along]});
  return std::nullopt;
}

}  // namespace hapticd
