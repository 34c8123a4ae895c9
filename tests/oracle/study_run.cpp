// See study_run.h.
#include "tests/oracle/study_run.h"

#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace hapticd {
namespace {

int tick_count(double rate_hz) { return static_cast<int>(std::lround(kStudyGesture_s * rate_hz)); }

double smallest(const ObstacleGaps& gaps) {
  double gap = kFarthestGap;
  for (const double each : gaps.capsules) gap = std::min(gap, each);
  for (const double each : gaps.bodies) gap = std::min(gap, each);
  return gap;
}

/// Leads a second tool along the way of `tick`; smallest gap on it.
double judge_tick(PathRun& run, const ToolScene& view, const RenderedTool& tick, bool first) {
  if (first) run.place(tick.X_WH);
  run.follow(view);
  const double gap = run.judged_tick(tick.X_WH, tick.dt);
  const Pose& X_WG = run.X_WG();
  if (!(to_array(X_WG.p) == to_array(tick.X_WG.p) && to_array(X_WG.q) == to_array(tick.X_WG.q))) {
    throw std::logic_error("the judged way leads elsewhere than the simulation's");
  }
  return gap;
}

}  // namespace

double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

std::vector<StudyTick> play_study(const Scene& scene, std::size_t tool, const StudySetting& setting,
                                  const StudyGesture& gesture, PathRun* judge) {
  const OwnedSimulation play = scene.simulate(tool);
  play.simulation->scene(0).options = setting.options;
  if (judge != nullptr) judge->restart();
  const auto told = std::make_unique<Tick>();
  static_cast<void>(told->tools.append());
  std::vector<StudyTick> ticks;
  bool out = false;
  for (int k = 0; k < tick_count(setting.rate_hz); ++k) {
    const double t = k / setting.rate_hz;
    const Pose X_WH = gesture.at(t);
    told->tools[0].placed = {std::llround(1e9 * (t + 1.0)), to_array(X_WH.p), to_array(X_WH.q)};
    const double before = processor_time();
    play.simulation->step(*told);
    const double after = processor_time();
    const RenderedTool& tick = play.simulation->rendered(0);
    StudyTick& kept = ticks.emplace_back();
    kept.felt_W = tick.F_computed_H_W.f;
    kept.contact_W = tick.contact.F_H_W.f;
    kept.torque_W = tick.F_computed_H_W.t;
    kept.X_WG = tick.X_WG;
    kept.touches = tick.contact.active_count > 0;
    kept.counts = tick.contact;
    kept.cpu_us = after - before;
    out = out || tick.contact.status != ContactStatus::kRecovering;
    if (judge != nullptr) {
      const double gap = judge_tick(*judge, play.simulation->scene(0), tick, k == 0);
      if (out) kept.path_gap_m = gap;
    }
  }
  return ticks;
}

std::vector<StudyTick> play_baseline(const Scene& scene, std::size_t tool, BaselineMethod method,
                                     const StudyGesture& gesture, PathJudge& judge) {
  const ToolScene view = scene.tool_scene(tool);
  BaselineOptions options;
  options.method = method;
  Baseline baseline(view, options);
  std::vector<StudyTick> ticks;
  constexpr double kRate = 1000.0;
  for (int k = 0; k < tick_count(kRate); ++k) {
    const double before = processor_time();
    const BaselineTick tick = baseline.tick(view, gesture.at(k / kRate), k > 0 ? 1 / kRate : 0.0);
    const double after = processor_time();
    StudyTick& kept = ticks.emplace_back();
    kept.felt_W = tick.F_H_W.f;
    kept.contact_W = tick.F_H_W.f;
    kept.torque_W = tick.F_H_W.t;
    kept.X_WG = tick.X_WG;
    kept.touches = tick.pairs > 0;
    kept.cpu_us = after - before;
    ContactState state;
    state.X_WG = tick.X_WG;
    kept.path_gap_m = smallest(judge.gaps(state));
  }
  return ticks;
}

}  // namespace hapticd
