// The measuring of a device's damping by the loop: against handles that ring in a simulation, and
// what ends it. Truth: the handles' own numbers (tests/support/ringing_handle.h).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/tick/measuring_plan.h"
#include "device/attach/damping_run.h"
#include "server/haptic_loop/known_spring.h"
#include "server/haptic_loop/settings_change.h"
#include "tests/server/haptic_loop/loop_run.h"
#include "tests/server/haptic_loop/ringing_device.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

/// A loop with such a device (ringing_device.h) before the wall, engaged; nobody knows its damping.
class MeasuredRun {
 public:
  explicit MeasuredRun(const HandleTruth& truth, double rate = 1000.0, double force = 4.0) {
    LoopOptions options;
    options.virtual_time = true;
    options.period_ns = static_cast<std::int64_t>(1e9 / rate);
    const double tick_s = 1e-9 * static_cast<double>(options.period_ns);
    RingingScene scene(truth, tick_s);
    handle = scene.handle;
    PlayedTool& tool = scene.played->tools[0];
    tool.limits.peak.force = force;
    tool.stiffness_limits.period_s = tick_s;
    apply_settings(*scene.played);
    loop_ = std::make_unique<HapticLoop>(options, std::move(scene.played), *channels_);
    run(5);
    send(EngageCommand{});
    while (told().state != LoopState::kEngaged && told().tick < 3000) tick();
    run(static_cast<int>(0.25 * rate));
    REQUIRE(told().state == LoopState::kEngaged);
  }

  void tick() {
    loop_->tick_once(0);
    LoopEvent event;
    while (channels_->events.pop(event)) {
      if (std::holds_alternative<CommandRefused>(event.what)) ++refused;
    }
    while (channels_->ticks.pop(*told_)) {
      if (run_ && !fit) fit = run_->take(*told_);
    }
  }
  void run(int ticks) {
    for (int k = 0; k < ticks; ++k) tick();
  }
  void send(const LoopCommandBody& what) { REQUIRE(channels_->commands.push({++commands_, what})); }
  void begin() {
    send(MeasureCommand{0, 5});
    handle->free = true;
    fit.reset();
    run_.emplace(0, PushAxis{5}, told_->tick + 1);
  }
  /// A whole measuring.
  DampingFit measure() {
    begin();
    for (int k = 0; k < 40'000 && !fit; ++k) tick();
    REQUIRE(fit);
    return *fit;
  }
  [[nodiscard]] const Tick& told() const { return *told_; }
  [[nodiscard]] HapticLoop& loop() { return *loop_; }

  RingingDevice* handle = nullptr;
  std::optional<DampingFit> fit;
  int refused = 0;

 private:
  std::unique_ptr<LoopChannels> channels_ = std::make_unique<LoopChannels>();
  std::unique_ptr<HapticLoop> loop_;
  std::unique_ptr<Tick> told_ = std::make_unique<Tick>();
  std::optional<DampingRun> run_;
  std::uint64_t commands_ = 0;
};

/// Ticks of 1 kHz until a ring was let go.
constexpr int kUntilFree = 600;

}  // namespace

TEST_CASE("what the loop measures of any handle holds, and a hand that holds on adds nothing") {
  SplitMix64 random(fresh_seed());
  int measured = 0;
  for (int k = 0; k < 40; ++k) {
    const bool held = k % 4 == 3;
    const HandleTruth truth = any_handle(random, held);
    const double rate = 500.0 * std::pow(8.0, random.uniform());
    MeasuredRun run(truth, rate, random.chance(0.5) ? 0.3 : 4.0);
    CAPTURE(truth.mass);
    CAPTURE(truth.damping);
    CAPTURE(truth.friction);
    CAPTURE(truth.weight);
    CAPTURE(truth.step);
    CAPTURE(truth.delay);
    CAPTURE(truth.hand_stiffness);
    CAPTURE(rate);
    const DampingFit fit = run.measure();
    if (fit.verdict != RingVerdict::kMeasured) continue;
    CHECK(fit.bounds.lower <= truth.damping);
    if (held) continue;
    ++measured;
    CHECK(fit.bounds.upper >= truth.damping);
  }
  CHECK(measured >= 8);
}

TEST_CASE("a device that was just checked, with 0.3 N at most, can be measured") {
  const DampingFit fit = MeasuredRun(HandleTruth{}, 1000.0, 0.3).measure();
  REQUIRE(fit.verdict == RingVerdict::kMeasured);
  CHECK(fit.bounds.lower > 0.7);
  CHECK(fit.bounds.lower <= 1.0);
}

TEST_CASE("the force of a measuring is small, and comes from no more than a soft spring") {
  HandleTruth truth;
  truth.damping = 0.3;
  MeasuredRun run(truth);
  run.begin();
  double largest = 0.0;
  while (!run.fit) {
    run.tick();
    largest = std::max(largest, to_vector(run.handle->written.f_H_D).norm());
    CHECK(run.handle->written.f_H_D[0] == within(0.0, 1e-9));
    CHECK(run.told().tools[0].port.given < 4e-3);
  }
  CHECK(largest > 0.1);
  CHECK(largest < 0.4);
  CHECK(run.fit->verdict == RingVerdict::kMeasured);
  run.run(300);
  CHECK(to_vector(run.handle->written.f_H_D).isZero(0.0));
  CHECK(run.told().state == LoopState::kEngaged);
}

TEST_CASE("Stop, Disengage and an open clutch end a measuring, which has found nothing") {
  for (const int what : {0, 1, 2}) {
    CAPTURE(what);
    MeasuredRun run(HandleTruth{});
    run.begin();
    run.run(kUntilFree);
    CHECK_FALSE(run.fit);
    if (what == 0) run.send(StopCommand{});
    if (what == 1) run.send(DisengageCommand{});
    if (what == 2) run.send(ClutchCommand{0, true});
    run.run(2);
    REQUIRE(run.fit);
    CHECK(run.fit->verdict == RingVerdict::kCut);
    run.run(100);
    CHECK(to_vector(run.handle->written.f_H_D).isZero(0.0));
  }
}

TEST_CASE("a handle that is led away is let go, and was not measured") {
  MeasuredRun run(HandleTruth{});
  run.begin();
  run.run(kUntilFree);
  for (int k = 0; k < 200; ++k) {
    run.handle->offset = std::min(1e-3 * k, 0.04);
    run.tick();
  }
  REQUIRE(run.fit);
  // The hand's work may meet the limit of energy first.
  CHECK((run.fit->verdict == RingVerdict::kMoved || run.fit->verdict == RingVerdict::kLimited));
  CHECK(to_vector(run.handle->written.f_H_D).isZero(0.0));
}

TEST_CASE("a handle whose weight is not borne meets the limits, and is not measured by them") {
  HandleTruth truth;
  truth.weight = -1.5;
  const DampingFit fit = MeasuredRun(truth, 1000.0, 0.3).measure();
  CHECK((fit.verdict == RingVerdict::kLimited || fit.verdict == RingVerdict::kMoved));
}

TEST_CASE("without force nothing is measured") {
  MeasuredRun run(HandleTruth{});
  run.send(DisengageCommand{});
  run.run(100);
  run.send(MeasureCommand{0, 5});
  run.run(5);
  CHECK(run.refused == 1);
  CHECK(to_vector(run.handle->written.f_H_D).isZero(0.0));
}

TEST_CASE("a handle that lies still against the spring is no stuck sensor") {
  HandleTruth truth;
  truth.friction = 3.0;
  MeasuredRun run(truth);
  CHECK(run.measure().verdict == RingVerdict::kNoRing);
  CHECK(run.told().state == LoopState::kEngaged);
}

TEST_CASE("a snapshot taken while a handle rings goes on as the loop did") {
  MeasuredRun run(HandleTruth{});
  run.begin();
  run.run(kUntilFree);
  auto snapshot = std::make_unique<Snapshot>();
  REQUIRE(run.loop().fill_snapshot(*snapshot));
  MeasuredRun other(HandleTruth{});
  REQUIRE(other.loop().restore(*snapshot));
  auto again = std::make_unique<Snapshot>();
  REQUIRE(other.loop().fill_snapshot(*again));
  CHECK(hash_of(*again) == hash_of(*snapshot));
  CHECK(std::any_of(snapshot->blocks.begin(), snapshot->blocks.end(),
                    [](const StateSpan& block) { return block.kind == StateKind::kMeasuring; }));
}

TEST_CASE("measuring again and again forgives nothing that the hand was given before") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int k = 0; k < 100; ++k) {
    KnownSpring spring;
    PortEnergy port;
    const double before = random.uniform(1e-6, 5e-3);
    port.given = before;
    SpringTick tick{5, LoopState::kEngaged, false, 1e-3, Vector3::Zero()};
    follow_measuring(tick, spring, port);
    CHECK(port.given == 0.0);
    const bool asks_again = random.chance(0.5);
    const bool falls = random.chance(0.3);
    for (int i = 0; spring.axis != 0 && i < 100'000; ++i) {
      tick.asked = asks_again && i < 20'000 && random.chance(2e-4) ? PushAxis{1} : PushAxis{0};
      tick.clutch_open = random.chance(1e-4);
      if (falls && random.chance(1e-3)) tick.state = LoopState::kFault;
      follow_measuring(tick, spring, port);
    }
    CHECK(spring.axis == 0);
    CHECK(port.given == before);
  }
}

}  // namespace hapticd::test
