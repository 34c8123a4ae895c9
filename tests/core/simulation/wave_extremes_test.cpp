// Strings that sound in scenes and under hands that no instrument has: whatever happens, numbers
// stay numbers, and no string swings with more than was put into it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/math/state_fields.h"
#include "core/simulation/simulation_fields.h"
#include "tests/core/simulation/wave_scene.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

double log_uniform(SplitMix64& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

/// A string that may be anything that a scene may ask for.
StringParameters wild_string(SplitMix64& random) {
  StringParameters string;
  string.tension = random.chance(0.05) ? 0.0 : log_uniform(random, 0.1, 300.0);
  string.frequency = log_uniform(random, 1.0, 2e4);
  string.axial_stiffness = random.chance(0.3) ? 0.0 : log_uniform(random, 1.0, 1e6);
  string.radius = random.chance(0.1) ? 0.0 : log_uniform(random, 1e-5, 5e-2);
  string.decay = log_uniform(random, 1e-3, 1000.0);
  string.contact_stiffness = log_uniform(random, 1e-3, 1e9);
  string.friction_coefficient = random.chance(0.5) ? 0.0 : random.uniform(0.0, 1.5);
  string.inharmonicity = random.chance(0.5) ? 0.0 : log_uniform(random, 1e-6, 0.1);
  const double length =
      random.chance(0.6) ? random.uniform(0.2, 2.0) : log_uniform(random, 1e-6, 1e7);
  string.p_WA = {0.0, 0.0, 0.0};
  string.p_WB = {length, 0.0, 0.0};
  return string;
}

double length_of(const StringParameters& string) { return string.p_WB[0]; }

/// Puts `string` in the place of the first of `instrument`.
void restring(const StringParameters& string, Instrument& instrument) {
  instrument.capsules_W[0] = {to_vector(string.p_WA), to_vector(string.p_WB), string.radius};
  instrument.groups[0] = group_capsules(instrument.capsules_W, 0);
  instrument.scene().obstacles.all = box_of(instrument.groups);
  instrument.strings[0] = derive_string(string);
}

/// Where a hand goes that has no manners.
class WildHand {
 public:
  WildHand(const StringParameters& string, double reach, SplitMix64& random)
      : length_(length_of(string)), reach_(reach), random_(random), p_(goal()) {}

  Vector3 next() {
    if (random_.chance(0.02)) {
      aim_ = goal();
      speed_ = log_uniform(random_, 0.01, 20.0);
    }
    if (random_.chance(0.003)) p_ = goal();
    if (random_.chance(0.001))
      p_ += 3.0 * Vector3(random_.uniform(-1, 1), random_.uniform(-1, 1), random_.uniform(-1, 1));
    const Vector3 way = aim_ - p_;
    const double far = way.norm();
    if (far > 0.0) p_ += way * std::min(1.0, 1e-3 * speed_ / far);
    return p_;
  }

 private:
  Vector3 goal() {
    double lambda = random_.uniform();
    if (random_.chance(0.1)) lambda = random_.chance(0.5) ? 0.0 : 1.0;
    const double y = random_.chance(0.1) ? 0.0 : random_.uniform(-3.0, 3.0) * reach_;
    const double z = random_.chance(0.3) ? 0.0 : random_.uniform(-3.0, 3.0) * reach_;
    return {lambda * length_, y, z};
  }

  double length_, reach_;
  SplitMix64& random_;
  Vector3 p_, aim_{0.0, 0.0, 0.0};
  double speed_ = 0.1;
};

bool all_finite(const StringEvent& event) {
  double sum = event.lambda + event.normal_speed + event.tangential_speed + event.force +
               event.deflection + event.amplitude + event.level + event.frequency + event.decay +
               event.cents_per_s + event.inharmonicity + event.lambda_to;
  for (int k = 0; k < event.partial_count; ++k) {
    sum += static_cast<double>(event.partials[static_cast<std::size_t>(k)]);
  }
  for (const float x : event.decays) sum += static_cast<double>(x);
  for (const float x : event.phases) sum += static_cast<double>(x);
  for (const double x : event.p_WC) sum += x;
  for (const double x : event.nhat_OG_W) sum += x;
  return std::isfinite(sum);
}

bool all_finite(const WaveState& state) {
  double sum = state.ringing + state.stored + state.released + state.tank.energy;
  const ModalMotion& motion = state.string.motion;
  for (const PerMode* mode : {&motion.qy, &motion.qz, &motion.vy, &motion.vz}) {
    for (const double x : *mode) sum += x;
  }
  for (const Transverse& beyond : state.tank.beyond) sum += beyond.y + beyond.z;
  return std::isfinite(sum);
}

/// The first thing of a tick that is no number; empty: all are.
std::string broken(Instrument& instrument) {
  const RenderedTool& tool = instrument.output().tool(0);
  if (!tool.F_computed_H_W.f.allFinite() || !tool.F_computed_H_W.t.allFinite()) return "wrench";
  if (!tool.F_H_W.f.allFinite() || !tool.X_WG.p.allFinite()) return "limited wrench or pose";
  for (const StringEvent& event : instrument.output().events()) {
    if (!all_finite(event)) return "event " + std::to_string(static_cast<int>(event.kind));
    // As event.proto has it; clients drop what is beyond.
    if (std::abs(event.cents_per_s) > 1e5) return "glide";
  }
  for (const StringTick& row : instrument.output().strings()) {
    if (!std::isfinite(row.energy + row.radius_growth + row.vibration_force + row.lambda)) {
      return "row";
    }
  }
  const Tick& tick = instrument.output().record();
  if (!std::isfinite(tick.string_energy + tick.tank_energy)) return "energies";
  if (!all_finite(instrument.simulation().memory().waves.front().state)) return "state";
  return {};
}

struct Wild {
  StringParameters string;
  InstrumentOptions options = wave_options();
  double tip = kFingertip;
  double kt = 1000.0;
  bool live = false;  ///< tension and kt change between ticks
};

Wild wild_scene(SplitMix64& random) {
  Wild wild;
  wild.string = wild_string(random);
  wild.options.friction = random.chance(0.5);
  wild.options.anchor_stiffness = log_uniform(random, 1e-3, 1e9);
  wild.options.pitch_glide = random.chance(0.5);
  wild.options.modes = 1 + static_cast<int>(random.below(64));
  wild.options.substeps = 8 << random.below(4);
  wild.tip = log_uniform(random, 1e-4, 5e-2);
  wild.kt = log_uniform(random, 1e-3, 1e9);
  wild.live = random.chance(0.3);
  return wild;
}

void change(const Wild& wild, SplitMix64& random, Instrument& instrument) {
  StringParameters string = wild.string;
  string.tension = random.chance(0.3) ? 0.0 : log_uniform(random, 1e-9, 300.0);
  instrument.strings[0] = derive_string(string);
  instrument.scene().stiffness.kt = log_uniform(random, 1e-3, 1e9);
}

/// Milliseconds: uneven, sometimes none, sometimes a pause.
std::int64_t wild_time(SplitMix64& random) {
  if (random.chance(0.05)) return 0;
  if (random.chance(0.005)) return static_cast<std::int64_t>(random.uniform(0.0, 3e9));
  return static_cast<std::int64_t>(random.uniform(0.0, 5e6));
}

TEST_CASE("no scene and no hand makes a string that sounds lose its numbers") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t scenes = scaled(5000);
  std::uint64_t most_work = 0;
  for (std::int64_t i = 0; i < scenes; ++i) {
    const Wild wild = wild_scene(random);
    Instrument instrument(1, wild.string, wild.options, {{Vector3::Zero(), wild.tip}});
    restring(wild.string, instrument);
    instrument.scene().stiffness.kt = wild.kt;
    WildHand hand(wild.string, wild.tip + wild.string.radius, random);
    for (int k = 0; k < 200; ++k) {
      if (wild.live && random.chance(0.02)) change(wild, random, instrument);
      instrument.dt_ns = random.chance(0.5) ? 1'000'000 : wild_time(random);
      instrument.tick(hand.next());
      const std::string what = broken(instrument);
      CAPTURE(i);
      CAPTURE(k);
      CAPTURE(what);
      REQUIRE(what.empty());
      most_work = std::max(most_work, instrument.output().record().work.work);
    }
  }
  CHECK(most_work < 2'000'000);
}

/// What the last tick did to the string by its own books, J: more than its contact put in.
double too_much(const WaveState& before, const WaveState& now) {
  const WaveContact& was = before.string.contacts.front();
  const WaveContact& is = now.string.contacts.front();
  // A string that is laid anew where the law has it, or that is turned on alone, has other books.
  const bool anew = !was.near || !is.near || (was.astray > 0.05 && is.astray == 0.0);
  if (anew || !now.stepped || !before.stepped) return 0.0;
  return now.stored + is.path.stored - before.stored - was.path.stored - is.path.work;
}

TEST_CASE("a string of even tension swings with no more than its contacts put in") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t scenes = scaled(2000);
  for (std::int64_t i = 0; i < scenes; ++i) {
    Wild wild = wild_scene(random);
    wild.string.axial_stiffness = 0.0;
    wild.string.tension = log_uniform(random, 0.1, 300.0);
    wild.string.frequency = log_uniform(random, 20.0, 2000.0);
    wild.string.p_WB = {random.uniform(0.2, 2.0), 0.0, 0.0};
    Instrument instrument(1, wild.string, wild.options, {{Vector3::Zero(), wild.tip}});
    restring(wild.string, instrument);
    instrument.scene().stiffness.kt = wild.kt;
    WildHand hand(wild.string, wild.tip + wild.string.radius, random);
    const WaveState& now = instrument.simulation().memory().waves.front().state;
    double largest = 0.0;
    for (int k = 0; k < 400; ++k) {
      const WaveState before = now;
      instrument.tick(hand.next());
      largest = std::max(largest, now.stored + now.string.contacts.front().path.stored);
      CAPTURE(i);
      CAPTURE(k);
      CAPTURE(largest);
      if (now.string.tuning == before.string.tuning) {
        CHECK(too_much(before, now) <= 1e-9 * largest + 1e-15);
      }
    }
  }
}

/// Numbers of all that an instrument keeps from tick to tick.
struct Kept {
  std::vector<double> reals = std::vector<double>(20000);
  std::vector<std::int64_t> integers = std::vector<std::int64_t>(20000);
};

Kept keep(Instrument& instrument) {
  const SimulationMemory& memory = instrument.simulation().memory();
  const ToolPlay& play = memory.tools.front();
  Kept kept;
  StateWriter write({kept.reals, kept.integers});
  write(play.state, play.X_WH, play.view);
  write(memory.tracks.front(), memory.visits.front(), memory.waves.front().state);
  REQUIRE(write.good());
  kept.reals.resize(write.reals());
  kept.integers.resize(write.integers());
  return kept;
}

void take_back(const Kept& kept, const Instrument& from, Instrument& instrument) {
  const SimulationMemory& memory = instrument.simulation().memory();
  ToolPlay& play = memory.tools.front();
  StateReader read(kept.reals, kept.integers);
  read(play.state, play.X_WH, play.view);
  read(memory.tracks.front(), memory.visits.front(), memory.waves.front().state);
  REQUIRE(read.complete());
  const std::int32_t first = 0;
  REQUIRE(instrument.simulation().strings().set_awake({&first, 1}));
  instrument.t_ns = from.t_ns;
  instrument.p_WH = from.p_WH;
}

TEST_CASE("a string that is taken back in the middle of its ringing goes on with the same bits") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::int64_t scenes = scaled(300);
  int rang = 0;
  for (std::int64_t i = 0; i < scenes; ++i) {
    Wild wild = wild_scene(random);
    wild.string.p_WB = {random.uniform(0.2, 2.0), 0.0, 0.0};
    wild.string.tension = log_uniform(random, 1.0, 300.0);
    wild.string.frequency = log_uniform(random, 20.0, 1000.0);
    const std::vector<Sphere> tip{{Vector3::Zero(), wild.tip}};
    Instrument first(1, wild.string, wild.options, tip);
    Instrument second(1, wild.string, wild.options, tip);
    for (Instrument* instrument : {&first, &second}) {
      restring(wild.string, *instrument);
      instrument->scene().stiffness.kt = wild.kt;
    }
    WildHand hand(wild.string, wild.tip + wild.string.radius, random);
    const int before = 50 + static_cast<int>(random.below(400));
    for (int k = 0; k < before; ++k) first.tick(hand.next());
    if (first.simulation().strings().awake_strings().empty()) continue;
    ++rang;
    take_back(keep(first), first, second);
    CAPTURE(i);
    for (int k = 0; k < 100; ++k) {
      const Vector3 p = hand.next();
      first.tick(p);
      second.tick(p);
      REQUIRE(felt_force(first) == felt_force(second));
      REQUIRE(first.output().tool(0).X_WG.p == second.output().tool(0).X_WG.p);
      REQUIRE(keep(first).reals == keep(second).reals);
      REQUIRE(keep(first).integers == keep(second).integers);
    }
  }
  CHECK(rang > 0);
}

}  // namespace
}  // namespace hapticd::test
