// What spoils the measuring of a damping, as ticks tell it. Truth: what the test did to the ticks.
#include "device/attach/damping_run.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "core/tick/measuring_plan.h"
#include "tests/support/ringing_handle.h"

namespace hapticd::test {
namespace {

constexpr std::uint64_t kFirst = 100;
constexpr std::uint64_t kSpoilt = 700;

/// A whole measuring of a usual handle along y at 1 kHz; `spoil` may change each tick, or have it
/// left out by returning false.
DampingFit run_with(const std::function<bool(Tick&)>& spoil) {
  RingingHandle handle(HandleTruth{});
  DampingRun run(0, 3, kFirst);
  auto tick = std::make_unique<Tick>();
  double f = 0.0;
  for (std::uint64_t k = kFirst - 5; k < kFirst + 8000; ++k) {
    *tick = {};
    tick->tick = k;
    tick->t_ns = static_cast<std::int64_t>(k) * 1'000'000;
    tick->dt_ns = 1'000'000;
    tick->state = LoopState::kEngaged;
    ToolTick& tool = *tick->tools.append();
    tool = {};
    if (k == kFirst) tool.asked.measure = 3;
    const double t_s = 1e-3 * static_cast<double>(k) - 1e-3 * static_cast<double>(kFirst);
    const int ring = static_cast<int>(std::max(0.0, t_s) / kRing_s);
    const double x = handle.position();
    const double since_s = t_s - ring * kRing_s;
    f = -(ring % 2 == 0 ? 200.0 : 100.0) * x;
    if (since_s < 0.5) f += (ring < 2 ? 0.25 : -0.25) * std::clamp(5.0 * since_s, 0.0, 1.0);
    tool.sample.p_DH = {0.0, 0.1 + x, 0.0};
    tool.sample.t_ns = tick->t_ns;
    tool.f_written_H_D = {0.0, f, 0.0};
    handle.advance(f, 1e-3);
    if (!spoil(*tick)) continue;
    if (const auto fit = run.take(*tick)) return *fit;
  }
  return {RingVerdict::kTicksLost, {}};
}

/// How it ends where one tick is changed so.
RingVerdict spoilt_by(const std::function<void(Tick&)>& spoil) {
  return run_with([&](Tick& tick) {
           if (tick.tick == kSpoilt) spoil(tick);
           return true;
         })
      .verdict;
}

}  // namespace

TEST_CASE("the ticks of a whole measuring tell the damping along their axis") {
  const DampingFit fit = run_with([](Tick&) { return true; });
  REQUIRE(fit.verdict == RingVerdict::kMeasured);
  CHECK(fit.bounds.lower > 0.85);
  CHECK(fit.bounds.lower <= 1.0);
  CHECK(fit.bounds.upper >= 1.0);
}

TEST_CASE("a limit that interferes, a force that goes off, a hand and a change of scene spoil it") {
  for (const unsigned flag :
       {unsigned{kSaturated}, unsigned{kThermalLimited}, unsigned{kPassivityLimited}}) {
    CHECK(spoilt_by([&](Tick& tick) { tick.tools[0].flags = static_cast<std::uint16_t>(flag); }) ==
          RingVerdict::kLimited);
  }
  CHECK(spoilt_by([](Tick& tick) { tick.state = LoopState::kReleasing; }) == RingVerdict::kCut);
  CHECK(spoilt_by([](Tick& tick) { tick.state = LoopState::kFault; }) == RingVerdict::kCut);
  CHECK(spoilt_by([](Tick& tick) { tick.scene_id = 9; }) == RingVerdict::kCut);
  CHECK(spoilt_by([](Tick& tick) { tick.tools[0].flags = kClutched; }) == RingVerdict::kCut);
  CHECK(spoilt_by([](Tick& tick) { tick.tools[0].asked.measure = 3; }) == RingVerdict::kCut);
  CHECK(spoilt_by([](Tick& tick) { tick.tools.clear(); }) == RingVerdict::kCut);
  CHECK(spoilt_by([](Tick& tick) { tick.tools[0].sample.p_DH[0] = 0.016; }) == RingVerdict::kMoved);
}

TEST_CASE("ticks that were not told spoil it, ticks that the loop passed over do not") {
  CHECK(run_with([](Tick& tick) { return tick.tick != kSpoilt; }).verdict ==
        RingVerdict::kTicksLost);
  CHECK(run_with([](Tick& tick) { return tick.tick != kFirst; }).verdict ==
        RingVerdict::kTicksLost);
  const auto late = [](std::uint64_t by) {
    return run_with([by](Tick& tick) {
             if (tick.tick > kSpoilt && tick.tick <= kSpoilt + by) return false;
             if (tick.tick != kSpoilt + by + 1) return true;
             tick.skipped = by;
             tick.dt_ns = static_cast<std::int64_t>(by + 1) * 1'000'000;
             return true;
           })
        .verdict;
  };
  CHECK(late(1) == RingVerdict::kMeasured);
  CHECK(late(8) == RingVerdict::kTicksLost);
}

}  // namespace hapticd::test
