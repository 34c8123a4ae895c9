// Odd clocks, bad samples, jumps and live changes of the scene, while strings are touched and ring.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kPlace = 0.33;

const auto kNothing = [](const SimulationTick&) {};

/// A string that rings, with the finger clear above it.
Instrument ringing(const Preset& preset) {
  Instrument guqin(1, preset.string, preset.options);
  guqin.tick({kPlace, -2e-3, -10e-3});
  guqin.glide({kPlace, -2e-3, 20e-3}, 0.5, kNothing);
  guqin.glide({kPlace, 20e-3, 20e-3}, 0.5, kNothing);
  guqin.glide({kPlace, 20e-3, 0.0}, 0.5, kNothing);
  return guqin;
}

double energy(const Instrument& guqin) { return guqin.energy(0); }

/// What is kept of its energy, whatever was told of it, J.
double kept_energy(Instrument& guqin) {
  const SimulationMemory& memory = guqin.simulation().memory();
  return memory.waves.empty() ? guqin.state(0).vibration.energy : memory.waves[0].state.ringing;
}

bool all_finite(const SimulationTick& output) {
  bool finite = output.tool(0).F_H_W.f.allFinite() && output.tool(0).F_H_W.t.allFinite() &&
                output.tool(0).X_WG.p.allFinite();
  for (const StringTick& reading : output.strings()) {
    finite = finite && std::isfinite(reading.vibration_force) &&
             std::isfinite(reading.radius_growth) && to_vector(reading.deflection_W).allFinite();
  }
  for (const StringEvent& event : output.events()) {
    finite = finite && std::isfinite(event.amplitude) && std::isfinite(event.level) &&
             std::isfinite(event.normal_speed) && std::isfinite(event.tangential_speed);
  }
  return finite;
}

HandPose bad_sample(std::int64_t t_ns) {
  HandPose sample{t_ns, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  sample.p_WH[1] = std::numeric_limits<double>::quiet_NaN();
  return sample;
}

}  // namespace

TEST_CASE("a vibration decays by the time that has passed, whatever the ticks") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument even = ringing(preset);
    Instrument odd = ringing(preset);
    const double before = energy(even);
    for (int k = 0; k < 300; ++k) even.tick(even.p_WH);
    // The same 300 ms in gaps of 0.2, 0.001, 0.05, 0.049 s.
    for (const std::int64_t ms : {200, 1, 50, 49}) {
      odd.dt_ns = ms * 1'000'000;
      odd.tick(odd.p_WH);
    }
    const double left = before * std::exp(-0.6 / preset.string.decay);
    if (sounds(preset)) {
      // Higher modes decay faster; the energy is read now and then.
      CHECK(energy(even) <= 1.001 * left);
      CHECK(energy(even) >= 0.9 * left);
      CHECK(energy(odd) == within(energy(even), 3e-2));
      continue;
    }
    CHECK(energy(even) == within(left, 1e-9));
    CHECK(energy(odd) == within(energy(even), 1e-12));
    const auto turns =
        static_cast<std::int64_t>(even.state(0).vibration.phase - odd.state(0).vibration.phase);
    CHECK(std::abs(static_cast<double>(turns)) < 0x1p64 * 1e-9);
  }
}

TEST_CASE("a sample without new time changes nothing of a vibration, and no event comes twice") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument once = ringing(preset);
    Instrument twice = ringing(preset);
    const auto down = [&](Instrument& guqin, bool repeat) {
      guqin.glide({kPlace, 2e-3, 0.0}, 0.3, [&](const SimulationTick&) {
        if (!repeat) return;
        const HandPose same{guqin.t_ns, to_array(guqin.p_WH), {1.0, 0.0, 0.0, 0.0}};
        guqin.tick_sample(same);
        // Late samples are worth no more than repeated ones.
        guqin.tick_sample({guqin.t_ns - 5'000'000, same.p_WH, same.q_WH});
      });
      guqin.glide({kPlace, 20e-3, 0.0}, 0.3, kNothing);
    };
    down(once, false);
    down(twice, true);
    REQUIRE(once.events.size() == twice.events.size());
    for (std::size_t k = 0; k < once.events.size(); ++k) {
      CHECK(once.events[k].kind == twice.events[k].kind);
      CHECK(std::abs(once.events[k].t_ns - twice.events[k].t_ns) < 20'000);
    }
    CHECK(energy(twice) == within(energy(once), 0.02));
  }
}

TEST_CASE("what a hand does while no time passes is work of the next tick") {
  // A hand that always moves its own way in a tick without time can draw no more than another.
  Preset preset = deflecting_preset();
  preset.string.touch_decay = 10.0;
  Instrument guqin = ringing(preset);
  const double released = guqin.state(0).vibration.released_energy;
  guqin.glide({kPlace, felt_distance(guqin) - 1e-3, 0.0}, 0.2, kNothing);
  double given = 0.0;
  const Vector3 base = guqin.p_WH;
  Vector3 held = Vector3::Zero();
  Vector3 before = base;
  for (int k = 0; k < 4000; ++k) {
    // Along with the force, and back as soon as it turns.
    const double y = base.y() + (held.y() > 0.0 ? 0.3e-3 : -0.3e-3);
    const Vector3 p(kPlace, y, 0.0);
    const bool timeless = k % 2 == 0;
    if (!timeless) guqin.t_ns += guqin.dt_ns;
    const SimulationTick& output =
        guqin.tick_sample({guqin.t_ns, to_array(p), {1.0, 0.0, 0.0, 0.0}});
    given += held.dot(p - before);
    before = p;
    held = output.tool(0).F_computed_H_W.f;
    for (const PressedString& contact : output.tool(0).strings) held -= contact.F_W;
  }
  MESSAGE("drawn: " << given / released);
  CHECK(given <= 1.001 * released + 50e-6);
}

TEST_CASE("any dt is survived: 0, 5 ms, 1 s, backwards, at random") {
  for (const Preset& preset : all_presets()) {
    SplitMix64 random(7);
    Instrument guqin(3, preset.string, preset.options);
    CAPTURE(std::string(preset.name));
    bool finite = true;
    for (std::int64_t k = 0; k < scaled(20'000); ++k) {
      const std::int64_t steps[] = {0, 5'000'000, 1'000'000'000, -3'000'000, 1, 1'000'000};
      guqin.t_ns += steps[random.below(6)];
      const Vector3 p(0.33, random.uniform(-4e-3, 12e-3), random.uniform(-0.01, 0.05));
      finite =
          finite && all_finite(guqin.tick_sample({guqin.t_ns, to_array(p), {1.0, 0.0, 0.0, 0.0}}));
      CHECK(guqin.output().tool(0).F_H_W.f.norm() <= WrenchLimits{}.force * (1.0 + 1e-12));
    }
    CHECK(finite);
  }
}

TEST_CASE("a force held over a tick without time does not attract") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument guqin = ringing(preset);
    guqin.glide({kPlace, felt_distance(guqin) - 0.5e-3, 0.0}, 0.2, kNothing);
    double weakest = 1.0;
    bool drawn = false;
    for (int k = 0; k < 50; ++k) {
      const Vector3 p = guqin.tick(guqin.p_WH).tool(0).X_WH.p;
      drawn = drawn || (guqin.reading(0) != nullptr && guqin.reading(0)->vibration_force < 0.0);
      guqin.tick_sample({guqin.t_ns, {p.x(), p.y() + 0.45e-3, p.z()}, {1.0, 0.0, 0.0, 0.0}});
      weakest = std::min(weakest, guqin.normal_force(0));
    }
    CHECK(drawn);
    CHECK(weakest >= -1e-12);  // the rounding of a sum of forces, N
  }
}

TEST_CASE("bad samples hold the string for two ticks, then fault") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument guqin = ringing(preset);
    guqin.glide({kPlace, felt_distance(guqin) - 1e-3, 0.0}, 0.2, kNothing);
    const auto events = guqin.events.size();
    const double before = kept_energy(guqin);
    for (std::int64_t k = 1; k <= 10; ++k) {
      guqin.tick_sample(bad_sample(guqin.t_ns + k * 1'000'000));
      CHECK(guqin.verdict() == (k <= 2 ? PoseVerdict::kHeld : PoseVerdict::kFault));
      CHECK((guqin.output().tool(0).F_H_W.f.norm() > 0.0) == (k <= 2));
    }
    CHECK(guqin.events.size() == events);
    CHECK(kept_energy(guqin) == before);
    guqin.clear();
    guqin.tick(guqin.p_WH);
    CHECK(guqin.verdict() == PoseVerdict::kGood);
    CHECK(guqin.events.size() == events);
  }
}

TEST_CASE("after a fault a string has decayed by the time that has passed, and by nothing else") {
  for (const Preset& preset : {paper_preset(), deflecting_preset()}) {
    CAPTURE(std::string(preset.name));
    // At several phases of the vibration; no force was rendered meanwhile, so where the hand has
    // gone was no work.
    for (int wait = 0; wait < 16; wait += 2) {
      for (const double gone : {-0.3e-3, 0.3e-3}) {
        Instrument guqin = ringing(preset);
        guqin.glide({kPlace, felt_distance(guqin) - 1e-3, 0.0}, 0.2, kNothing);
        for (int k = 0; k < wait; ++k) guqin.tick(guqin.p_WH);
        const double before = energy(guqin);
        for (std::int64_t k = 1; k <= 10; ++k) {
          guqin.tick_sample(bad_sample(guqin.t_ns + k * 1'000'000));
        }
        guqin.clear();
        guqin.dt_ns = 15'000'000;
        guqin.tick(Vector3(guqin.p_WH + Vector3(0.0, gone, 0.0)));
        const double keep = std::exp(-0.03 / preset.string.touch_decay);
        CHECK(energy(guqin) == within(before * keep, 1e-9));
      }
    }
  }
}

TEST_CASE("a jump past no string plays nothing; one across strings stays within the limits") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument guqin(7, preset.string, preset.options);
    guqin.tick({kPlace, 0.05, 0.06});
    for (const Vector3& to : {Vector3(0.5, 0.25, 0.0), Vector3(0.2, 0.05, 0.1),
                              Vector3(5.0, 10.0, 3.0), Vector3(0.4, 0.03, 0.05)}) {
      for (int k = 0; k < 3; ++k) guqin.tick(to);
    }
    CHECK(guqin.events.empty());

    SplitMix64 random(3);
    bool finite = true;
    for (std::int64_t k = 0; k < scaled(2000); ++k) {
      const double reach = random.chance(0.5) ? 0.2 : 10.0;
      const Vector3 to = Vector3(0.5, 0.0, 0.06) + reach * to_vector(random.direction());
      for (int hold = 0; hold < 5; ++hold) {
        finite = finite && all_finite(guqin.tick(to));
        CHECK(guqin.output().tool(0).F_H_W.f.norm() <= WrenchLimits{}.force * (1.0 + 1e-12));
      }
    }
    CHECK(finite);
    CHECK(count(guqin.events, StringEventKind::kTone) <=
          count(guqin.events, StringEventKind::kRelease));
  }
}

TEST_CASE("a slack string is felt no more than it pulls, and plays no tone") {
  for (Preset preset : all_presets()) {
    for (const double youngs_modulus : {0.0, 1.9e11}) {
      preset.string.tension = 0.0;
      preset.string.youngs_modulus = youngs_modulus;
      CAPTURE(std::string(preset.name));
      Instrument guqin(1, preset.string, preset.options);
      bool finite = true;
      guqin.tick({kPlace, -2e-3, -10e-3});
      for (int k = 0; k < 4; ++k) {
        guqin.glide({kPlace, -2e-3, k % 2 == 0 ? 10e-3 : -10e-3}, 0.5,
                    [&](const SimulationTick& output) { finite = finite && all_finite(output); });
      }
      CHECK(finite);
      CHECK(count(guqin.events, StringEventKind::kTone) == 0);
      if (youngs_modulus > 0.0) CHECK(count(guqin.events, StringEventKind::kTouch) >= 4);
    }
  }
}

TEST_CASE("parameters may change while a string is pressed or rings") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    StringParameters tighter = preset.string;
    tighter.p_WB = {1.1, 0.0, 0.0};
    tighter.frequency = kTuning[0];
    tighter.tension *= 1.5;

    // While it rings: it goes on ringing.
    Instrument rung = ringing(preset);
    const int events = count_played(rung.events);
    rung.strings[0] = derive_string(tighter);
    bool finite = true;
    for (int k = 0; k < 100; ++k) finite = finite && all_finite(rung.tick(rung.p_WH));
    CHECK(finite);
    CHECK(count_played(rung.events) == events);
    CHECK(rung.reading(0) != nullptr);

    // While it is pressed: the force changes, and nothing else happens.
    Instrument pressed(1, preset.string, preset.options);
    pressed.tick({kPlace, 10e-3, 0.0});
    pressed.glide({kPlace, felt_distance(pressed) - 2e-3, 0.0}, 0.1, kNothing);
    for (int k = 0; k < 100; ++k) pressed.tick(pressed.p_WH);
    const int before = count_played(pressed.events);
    const auto mean_force = [&] {
      double mean = 0.0;
      for (int k = 0; k < 500; ++k) {
        finite = finite && all_finite(pressed.tick(pressed.p_WH));
        mean += 0.002 * pressed.output().tool(0).F_H_W.f.norm();
      }
      return mean;
    };
    const double force = mean_force();
    pressed.strings[0] = derive_string(tighter);
    const double change = mean_force() / force;
    // 1.5 times as stiff, softened by the coupling in series where the string yields.
    CHECK(change > 1.3);
    CHECK(change < 1.5);
    CHECK(count_played(pressed.events) == before);

    // Back and forth in every tick: no storm of events.
    const StringConstants one = derive_string(preset.string);
    for (int k = 0; k < 500; ++k) {
      pressed.strings[0] = k % 2 == 0 ? pressed.strings[0] : one;
      pressed.strings[0].tension = k % 2 == 0 ? 45.0 : 30.0;
      finite = finite && all_finite(pressed.tick(pressed.p_WH));
    }
    CHECK(finite);
    CHECK(count_played(pressed.events) == before);
  }
}

TEST_CASE("options may change while a string rings: what is off falls silent") {
  for (const Preset& preset : all_presets()) {
    CAPTURE(std::string(preset.name));
    Instrument guqin = ringing(preset);
    guqin.scene().instrument.vibration = false;
    guqin.tick(guqin.p_WH);
    CHECK(guqin.reading(0) == nullptr);
    const auto radii = of_kind(guqin.events, StringEventKind::kRadius);
    CHECK(radii.back().radius_phase == RadiusPhase::kRelease);
    CHECK(radii.back().amplitude == 0.0);
    guqin.scene().instrument.vibration = true;
    const auto events = guqin.events.size();
    for (int k = 0; k < 10; ++k) guqin.tick(guqin.p_WH);
    CHECK(guqin.events.size() == events);
  }
}

}  // namespace hapticd::test
