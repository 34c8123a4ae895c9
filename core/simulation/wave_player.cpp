// See wave_player.h. RT: yes.
#include "core/simulation/wave_player.h"

#include <algorithm>

#include "core/instrument/wave_sounding.h"
#include "core/instrument/wave_tank.h"
#include "core/instrument/wave_tone.h"
#include "core/instrument/wave_watch.h"
#include "core/simulation/rest_meeting.h"
#include "core/simulation/touch_place.h"
#include "core/simulation/wave_force.h"
#include "core/simulation/wave_meeting.h"
#include "core/simulation/wave_tension.h"

namespace hapticd {
namespace {

/// A string that nobody is near is read so often, ns.
constexpr std::int64_t kReadEvery_ns = 50'000'000;
/// And so often while its pitch glides.
constexpr std::int64_t kReadGlideEvery_ns = 5'000'000;
/// It falls asleep where it swings by less, m.
constexpr double kLeastSwing = 2e-6;

/// Reads its energies at string.done_ns.
void read_energies(const Playing& playing) noexcept {
  WaveState& state = playing.kept.state;
  state.stored = energy(playing.kept.table.modes, state.string.motion);
  state.ringing = ringing_energy(playing.kept.table, state.string);
}

void wake(const Playing& playing) noexcept {
  WaveState& state = playing.kept.state;
  if (!state.awake) {
    rest(playing.time.t_ns - playing.time.dt_ns, state.string);
    state.stored = 0.0;
    state.ringing = 0.0;
    state.awake = true;
  } else if (!state.stepped) {
    turn_to(playing.time.t_ns - playing.time.dt_ns, playing.kept.table, state.string);
    read_energies(playing);
  }
  for (WaveGrip& grip : state.grips) {
    if (grip.touching) continue;
    grip.energy_before = state.ringing;
  }
}

ToolStringState& visit(const Playing& playing, std::size_t tool) noexcept {
  const SimulationMemory& memory = playing.wave.memory;
  return memory.visits[tool * memory.tracks.size() + static_cast<std::size_t>(playing.wave.string)];
}

Toucher toucher(const Playing& playing, std::size_t tool) noexcept {
  return {playing.wave.memory.tools[tool], static_cast<std::int32_t>(tool), playing.wave.string,
          playing.time, visit(playing, tool)};
}

/// What the next tick has to know.
void remember_all(const Playing& playing, const NearTools& tools) noexcept {
  for (std::size_t k = 0; k < playing.wave.memory.tools.size(); ++k) {
    ToolStringState& seen = visit(playing, k);
    const StringProximity& near = tools[k].proximity;
    if (near.part >= 0) seen.part = near.part;
    remember(toucher(playing, k), near, playing.kept.state.grips[k].felt_ns, seen);
  }
}

void watch(const Playing& playing, const WaveTick& stepped, const NearTools& tools,
           StringEvents& events) noexcept {
  const WatchedWave watched{playing.wave.string, playing.string, playing.options,
                            playing.kept.table, playing.kept.state};
  for (std::size_t k = 0; k < playing.wave.memory.tools.size() && stepped.steps > 0; ++k) {
    const StringTouch& touch = tools[k].proximity.touch;
    const std::size_t first = events.size();
    watch_grip(watched, stepped,
               {k, touch.force > 0.0, touch.force > 0.0 ? touch.deflection : 0.0,
                touch.normal_speed, touch.tangential_speed},
               events);
    name_place(first, toucher(playing, k), events);
  }
  const std::size_t first = events.size();
  watch_envelope(watched, playing.time.t_ns, events);
  watch_sounding(watched, playing.kept.state.string.done_ns, !playing.kept.state.stepped, events);
  for (std::size_t k = first; k < events.size(); ++k) {
    events[k].tool = playing.kept.state.player;
  }
}

/// The row of a string that is awake.
void tell(const Playing& playing, const NearTools& tools, Tick& tick) noexcept {
  const WaveState& state = playing.kept.state;
  StringTick row;
  row.string = playing.wave.string;
  row.tool = state.player;
  const auto player = static_cast<std::size_t>(state.player);
  const WaveGrip& grip = state.grips[player];
  row.phase = StringPhase::kModes;
  row.touched = grip.touching;
  row.armed = grip.armed;
  row.lambda = grip.lambda;
  const double since = 1e-9 * static_cast<double>(playing.time.t_ns - state.string.done_ns);
  const double fallen = std::max(0.0, 1.0 - 2.0 * since / playing.string.decay);
  row.energy = state.ringing * fallen;
  row.radius_growth = std::max(amplitude_of(state.string.tuning, row.energy), grip.deflection);
  if (state.stepped && grip.touching) {
    const NearTool& tool = tools[player];
    row.deflection_W = to_array(tool.proximity.u_W);
    const Transverse& beyond = state.tank.beyond[player];
    const Transverse n = across(playing.frame, tool.proximity.nhat_W);
    row.vibration_force = beyond.y * n.y + beyond.z * n.z;
  }
  tick.strings.push_back(row);
  tick.string_energy += row.energy;
}

/// True once it is as good as still, and nobody touches it.
bool is_quiet(const Playing& playing) noexcept {
  const WaveState& state = playing.kept.state;
  for (const WaveGrip& grip : state.grips) {
    if (grip.touching) return false;
  }
  const double least = playing.options.sleep_energy * state.released;
  return state.ringing <= least || amplitude_of(state.string.tuning, state.ringing) < kLeastSwing;
}

/// Rings, and nobody is near.
void ring_on(const Playing& playing) noexcept {
  WaveState& state = playing.kept.state;
  if (state.stepped) {
    for (WaveContact& contact : state.string.contacts) contact = WaveContact{};
    state.tank.beyond = {};
    state.tank.law = {};
    state.tank.stored = {};
    state.stepped = false;
    read_energies(playing);
  }
  const bool glides = state.string.tuning.tension != state.held_tension;
  const std::int64_t pause = playing.time.t_ns - state.string.done_ns;
  const bool as_before = playing.string.tension == state.held_tension;
  if (as_before && pause < (glides ? kReadGlideEvery_ns : kReadEvery_ns)) return;
  turn_to(playing.time.t_ns, playing.kept.table, state.string);
  tune(playing, playing.string.tension);
  read_energies(playing);
}

}  // namespace

bool is_wave(const SimulationMemory& memory, std::int32_t string) noexcept {
  if (memory.waves.empty()) return false;
  const InstrumentOptions& options = memory.tools.front().scene.instrument;
  const StringConstants& constants = constants_of(memory, string);
  return options.vibration && options.modes > 0 && constants.frequency > 0.0 &&
         constants.frequency <= highest_wave_frequency(options.substeps) &&
         constants.tension > 0.0 && constants.max_level == StringDetail::kModes &&
         constants.model == StringContact::kYielding;
}

void silence_wave(const PlayedWave& wave, StringEvents& events) noexcept {
  WaveMemory& kept = kept_of(wave.memory, wave.string);
  const ToolPlay& front = wave.memory.tools.front();
  const std::int64_t t_ns = front.way.time.t_ns;
  const WatchedWave watched{wave.string, constants_of(wave.memory, wave.string),
                            front.scene.instrument, kept.table, kept.state};
  const std::size_t first = events.size();
  tell_silence(watched, t_ns, events);
  end_sounding(watched, t_ns, events);
  for (std::size_t k = first; k < events.size(); ++k) events[k].tool = kept.state.player;
  end_wave(kept);
}

void end_wave(WaveMemory& wave) noexcept {
  const double energy = std::min(wave.state.tank.energy, kTankReserve);
  const bool sounded = wave.state.sounded;
  const std::int64_t sounded_ns = wave.state.sounded_ns;
  const std::uint32_t number = wave.state.sounding.number;
  wave.state = WaveState{};
  wave.state.sounding.number = number;
  wave.state.tank.energy = energy;
  wave.state.sounded = sounded;
  wave.state.sounded_ns = sounded_ns;
}

double wave_swing(const SimulationMemory& memory, std::int32_t string) noexcept {
  const WaveState& state = kept_of(memory, string).state;
  return state.awake ? reach_of(state.string.tuning, state.stored, 0.5) : 0.0;
}

void play_wave(const PlayedWave& wave, Tick& tick, StringEvents& events) noexcept {
  const ToolPlay& front = wave.memory.tools.front();
  Playing playing{wave,
                  constants_of(wave.memory, wave.string),
                  front.scene.instrument,
                  frame_of(front.scene.obstacles.capsules_W[static_cast<std::size_t>(wave.string)]),
                  front.way.time,
                  kept_of(wave.memory, wave.string)};
  WaveState& state = playing.kept.state;
  NearTools tools;
  Touches touches{};
  if (!state.awake) tune(playing, playing.string.tension);
  // A state that was taken back has no table yet.
  retune(state.string.tuning, playing.kept.table, state.string);
  const bool near = find_near(playing, tools, touches);
  WaveRestTouches rests;
  if (near || state.awake) find_rests(playing, tools, touches, rests);
  if (playing.time.dt_ns <= 0) {
    hold_forces(playing, tools, touches);
    tell(playing, tools, tick);
    return;
  }
  WaveTick stepped;
  const bool watched = std::any_of(state.grips.begin(), state.grips.end(),
                                   [](const WaveGrip& grip) { return grip.touching; });
  if (near || watched || !rests.empty()) {
    wake(playing);
    state.stepped = true;
    tune(playing, tension_of(playing, tools, touches));
    stepped =
        step({playing.string, playing.options, playing.kept.table, {rests.begin(), rests.size()}},
             playing.time, std::span(touches).first(wave.memory.tools.size()), state.string);
    read_energies(playing);
    give_forces(playing, tools, touches);
  } else if (state.awake) {
    ring_on(playing);
  }
  watch(playing, stepped, tools, events);
  remember_all(playing, tools);
  if (!near && is_quiet(playing)) {
    silence_wave(wave, events);
    return;
  }
  tell(playing, tools, tick);
}

}  // namespace hapticd
