// See wave_player.h. RT: yes.
#include "core/simulation/wave_player.h"

#include <algorithm>
#include <cmath>

#include "core/contact/coupling_axes.h"
#include "core/instrument/deflection.h"
#include "core/instrument/string_model.h"
#include "core/instrument/wave_sounding.h"
#include "core/instrument/wave_tank.h"
#include "core/instrument/wave_tone.h"
#include "core/instrument/wave_watch.h"
#include "core/simulation/string_proximity.h"

namespace hapticd {
namespace {

/// Its tension is told from what bends it where that is at least this, m.
constexpr double kMinBend = 1e-6;
/// Tension that a bend may tell, over that at rest: more would turn the fastest modes by more than
/// a sub-step bears.
constexpr double kMinRaise = 0.5;
constexpr double kMaxRaise = 16.0;
/// And of that the most that its swinging may add: beyond it the swing would feed on itself.
constexpr double kMaxSwingRaise = 0.25;
/// A change of tension below this share is none: 0.02 cents.
constexpr double kSameTension = 2e-5;
/// A string that nobody is near is read so often, ns.
constexpr std::int64_t kReadEvery_ns = 50'000'000;
/// And so often while its pitch glides.
constexpr std::int64_t kReadGlideEvery_ns = 5'000'000;
/// It falls asleep where it swings by less, m.
constexpr double kLeastSwing = 2e-6;

/// Axes across the string, and along it.
struct StringFrame {
  Vector3 p_WA;
  Vector3 axis_W;  ///< A to B, m
  Vector3 y_W, z_W;
};

StringFrame frame_of(const Capsule& line) noexcept {
  StringFrame frame;
  frame.p_WA = line.p_A;
  frame.axis_W = line.p_B - line.p_A;
  const Vector3 x = frame.axis_W.normalized();
  const Vector3 up = std::abs(x.y()) < 0.9 ? Vector3::UnitY() : Vector3::UnitX();
  frame.y_W = (up - up.dot(x) * x).normalized();
  frame.z_W = x.cross(frame.y_W);
  return frame;
}

Transverse across(const StringFrame& frame, const Vector3& v_W) noexcept {
  return {v_W.dot(frame.y_W), v_W.dot(frame.z_W)};
}

Vector3 in_world(const StringFrame& frame, const Transverse& v) noexcept {
  return v.y * frame.y_W + v.z * frame.z_W;
}

double norm(const Transverse& a) noexcept { return std::sqrt(a.y * a.y + a.z * a.z); }

/// Where a point is along the string, not clamped to it.
double place_along(const StringFrame& frame, const Vector3& p_W) noexcept {
  return (p_W - frame.p_WA).dot(frame.axis_W) / frame.axis_W.squaredNorm();
}

/// Of what holds the contact of a tool, along its normal, m/N: its coupling, about whatever it
/// turns, its soft parts, and what kc is softer than the coupling.
double compliance_of(const ToolPlay& play, const StringProximity& near, double kc) noexcept {
  const ContactInput& input = play.way.input;
  const Vector3& n = near.nhat_W;
  const Vector3 t = (near.p_WC - play.rendered.X_WG.p).cross(n);
  const PoseError error =
      coupling_error(play.rendered.X_WG, input.X_WH, play.state.contact.phi_GH_W);
  const PoseError stretch = stretch_under(input.stiffness, input.X_WH.q, error, {n, t});
  const double coupling = -(stretch.dp.dot(n) + stretch.dtheta.dot(t));
  return coupling + near.compliance + std::max(0.0, 1.0 / kc - 1.0 / input.stiffness.kt);
}

/// One tool that is near the string.
struct NearTool {
  WaveTouch touch;
  StringProximity proximity;
};

/// Everything a tick of one string works on.
struct Playing {
  const PlayedWave& wave;
  const StringConstants& string;
  const InstrumentOptions& options;
  StringFrame frame;
  TickTime time;
  WaveMemory& kept;
};

const StringConstants& constants_of(const SimulationMemory& memory, std::int32_t string) noexcept {
  return memory.tools.front().scene.strings[static_cast<std::size_t>(string)];
}

WaveMemory& kept_of(const SimulationMemory& memory, std::int32_t string) noexcept {
  return memory.waves[static_cast<std::size_t>(string)];
}

/// What a soft part of the tool does to its touch, whether the static law has it press or not.
void soften(const Playing& playing, const ToolPlay& play, NearTool& tool) noexcept {
  WaveTouch& touch = tool.touch;
  touch.part_compliance = tool.proximity.compliance;
  touch.part_damping = 0.0;
  touch.part_aside = {};
  const std::span<const ToolPart> parts = play.scene.parts.parts;
  const auto part = static_cast<std::size_t>(tool.proximity.part);
  if (part >= parts.size() || !(parts[part].stiffness > 0.0)) return;
  touch.part_compliance = 1.0 / parts[part].stiffness;
  touch.part_damping = parts[part].damping;
  if (!(touch.force > 0.0)) touch.compliance += touch.part_compliance;
  for (const SoftPart& stands : play.state.contact.parts) {
    if (stands.part != tool.proximity.part) continue;
    touch.part_aside = across(playing.frame, play.rendered.X_WG.q * stands.v_G);
  }
}

/// What the tool does to the string, with the place where its sphere was at the start of the tick.
void aim(const Playing& playing, const ToolPlay& play, NearTool& tool) noexcept {
  const StringProximity& near = tool.proximity;
  const StringFrame& frame = playing.frame;
  WaveTouch& touch = tool.touch;
  touch.radius = near.radius +
                 play.scene.obstacles.capsules_W[static_cast<std::size_t>(playing.wave.string)].r;
  touch.force = near.touch.force;
  const Vector3 p_WS = near.p_WC + near.radius * near.nhat_W;
  const Pose& X_WG = play.rendered.X_WG;
  const Vector3 p_WS_before =
      play.way.X_WG_before.p + play.way.X_WG_before.q * (X_WG.q.conjugate() * (p_WS - X_WG.p));
  touch.lambda = std::clamp(place_along(frame, p_WS), 0.0, 1.0);
  touch.lambda_before = std::clamp(place_along(frame, p_WS_before), 0.0, 1.0);
  touch.centre = across(frame, p_WS - frame.p_WA);
  touch.centre_before = across(frame, p_WS_before - frame.p_WA);
  const Transverse n = across(frame, near.nhat_W);
  const double length = norm(n);
  touch.normal = length > 0.0 ? Transverse{n.y / length, n.z / length} : Transverse{1.0, 0.0};
  if (touch.force > 0.0) {
    // As the law has it: the string's vertex at the distance of the radius.
    const Transverse u = across(frame, near.u_W);
    touch.lambda = whole_lambda(play.view, playing.wave.string, near.touch.lambda);
    touch.centre = {u.y + touch.radius * touch.normal.y, u.z + touch.radius * touch.normal.z};
  }
  touch.compliance = compliance_of(
      play, near, std::min(playing.string.contact_stiffness, play.way.input.stiffness.kt));
  const Vector3 v_W = point_velocity(play.rendered.V_WH, near.p_WC - X_WG.p);
  touch.hand_speed = norm(across(frame, v_W));
  soften(playing, play, tool);
}

using NearTools = std::array<NearTool, kMaxTools>;
using Touches = std::array<const WaveTouch*, kMaxTools>;

/// The tools that press the string, or that it may meet.
bool find_near(const Playing& playing, NearTools& tools, Touches& touches) noexcept {
  const SimulationMemory& memory = playing.wave.memory;
  const auto s = static_cast<std::size_t>(playing.wave.string);
  const WaveState& state = playing.kept.state;
  bool any = false;
  for (std::size_t k = 0; k < memory.tools.size(); ++k) {
    const ToolPlay& play = memory.tools[k];
    touches[k] = nullptr;
    if (!play.state.placed) continue;
    NearTool& tool = tools[k];
    tool.proximity =
        proximity_to(play, memory.visits[k * memory.tracks.size() + s], playing.wave.string);
    const StringTouch& touch = tool.proximity.touch;
    if (tool.proximity.part < 0) continue;
    const double swing = reach_of(state.string.tuning, state.stored, touch.lambda);
    // Of a tool that holds the string the distance is from its bent shape.
    const bool meets = touch.force > 0.0 || state.grips[k].touching ||
                       touch.distance <= swing + playing.options.release.release_gap;
    if (!meets) continue;
    aim(playing, play, tool);
    touches[k] = &tool.touch;
    any = true;
  }
  return any;
}

/// Several tools press the string, or the one that does has been rendered when another did: its law
/// is that of a part.
bool is_parted(const Playing& playing, const Touches& touches) noexcept {
  const std::span<const ToolPlay> tools = playing.wave.memory.tools;
  std::size_t pressing = 0;
  bool parted = false;
  for (std::size_t k = 0; k < tools.size(); ++k) {
    if (touches[k] == nullptr || !(touches[k]->force > 0.0)) continue;
    ++pressing;
    parted = parted || part_of(tools[k].view, playing.wave.string) != nullptr;
  }
  return pressing > 1 || parted;
}

/// How much longer the tools bend the string, m.
double extension_of(const Playing& playing) noexcept {
  StringTools views;
  StringPoints points;
  string_points(string_tools(playing.wave.memory, views), playing.wave.sharing,
                playing.wave.string, -1, points);
  double polyline = 0.0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    polyline += (points[k + 1] - points[k]).norm();
  }
  return std::max(0.0, polyline - playing.string.length);
}

/// Of the string as the static laws of the tools bend it, N.
double tension_of(const Playing& playing, const NearTools& tools, const Touches& touches) noexcept {
  const StringConstants& string = playing.string;
  const NearTool* only = nullptr;
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k] != nullptr && touches[k]->force > 0.0) only = &tools[k];
  }
  if (only == nullptr) return string.tension;
  double tension = string.tension;
  if (is_parted(playing, touches)) {
    tension += string.axial_stiffness * (extension_of(playing) / string.length);
  } else {
    const double u = norm(across(playing.frame, only->proximity.u_W));
    const double run = only->touch.lambda * (1.0 - only->touch.lambda) * string.length;
    if (u < kMinBend || !(run > 0.0)) return playing.kept.state.held_tension;
    tension = norm(across(playing.frame, only->proximity.F_W)) * run / u;
  }
  return std::clamp(tension, kMinRaise * string.tension, kMaxRaise * string.tension);
}

/// What its swinging adds to the tension, N: E A times its mean extension, which holds half of its
/// energy.
double swing_tension(const Playing& playing, double held) noexcept {
  const StringConstants& string = playing.string;
  if (!playing.options.pitch_glide || !(string.axial_stiffness > 0.0)) return 0.0;
  const double extension = 0.5 * playing.kept.state.ringing / held;
  return std::min(string.axial_stiffness / string.length * extension, kMaxSwingRaise * held);
}

/// Of a string that its static laws hold at the tension `held`.
void tune(const Playing& playing, double held) noexcept {
  WaveString& string = playing.kept.state.string;
  playing.kept.state.held_tension = held;
  double tension = held + swing_tension(playing, held);
  const double before = string.tuning.tension;
  if (std::abs(tension - before) < kSameTension * before) tension = before;
  retune(tuning_at(playing.string, tension, playing.options.modes), playing.kept.table, string);
}

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

/// Static energy of the tool's law: of the string, where it is this tool's alone, and of what holds
/// the tool, J.
double law_energy(const ToolPlay& play, const Playing& playing, const NearTool& tool,
                  bool parted) noexcept {
  const double force = tool.touch.force;
  if (!(force > 0.0)) return 0.0;
  const double held = 0.5 * force * force * tool.touch.compliance;
  if (parted) return held;
  const auto s = static_cast<std::size_t>(playing.wave.string);
  const StringConstants& seen = play.way.input.strings[s];
  const double lambda = tool.proximity.touch.lambda;
  const double u = norm(across(playing.frame, tool.proximity.u_W));
  const Deflection law = ask_model(seen, [&](const auto& model) { return model.law(lambda, u); });
  return law.energy + held;
}

/// Of a string that several tools bend, J.
double shared_energy(const Playing& playing) noexcept {
  const StringConstants& string = playing.string;
  const double extension = extension_of(playing);
  return extension * (string.tension + 0.5 * string.axial_stiffness * extension / string.length);
}

void add_force(const Playing& playing, ToolPlay& play, const StringProximity& near,
               const Transverse& force) noexcept {
  const Vector3 f = in_world(playing.frame, force);
  Wrench& F_H_W = play.rendered.F_computed_H_W;
  F_H_W.f += f;
  F_H_W.t += (near.p_WC - play.rendered.X_WG.p).cross(f);
}

/// What of `beyond` leaves the whole no force into the string.
Transverse not_attracting(const Playing& playing, const NearTool& tool,
                          const Transverse& beyond) noexcept {
  const Transverse law = across(playing.frame, tool.proximity.F_W);
  const Transverse& n = tool.touch.normal;
  const double pull = -((law.y + beyond.y) * n.y + (law.z + beyond.z) * n.z);
  if (!(pull > 0.0)) return beyond;
  return {beyond.y + pull * n.y, beyond.z + pull * n.z};
}

/// A tick in which no time passes: what was held is.
void hold_forces(const Playing& playing, const NearTools& tools, const Touches& touches) noexcept {
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k] == nullptr) continue;
    add_force(playing, playing.wave.memory.tools[k], tools[k].proximity,
              not_attracting(playing, tools[k], playing.kept.state.tank.beyond[k]));
  }
}

/// What the next tick has to know.
void remember_all(const Playing& playing, const NearTools& tools) noexcept {
  const SimulationMemory& memory = playing.wave.memory;
  const auto s = static_cast<std::size_t>(playing.wave.string);
  for (std::size_t k = 0; k < memory.tools.size(); ++k) {
    ToolStringState& seen = memory.visits[k * memory.tracks.size() + s];
    const StringProximity& near = tools[k].proximity;
    if (near.part >= 0) seen.part = near.part;
    remember(memory.tools[k], near, seen);
  }
}

/// Force on the tool at the end of the tick, N: its mean, which is what it was half a tick ago, and
/// what the static law has changed by since. Without that a hand that presses on would feel half a
/// tick's press too little, and pay the tank for it. Only as far as the force itself has gone that
/// way since it was last given: where the law slips off the string, the string may not have yet.
Transverse felt_now(const StringContactPath& path, const Transverse& law, std::size_t tool,
                    const WaveTank& tank) noexcept {
  const Transverse mean{-path.force.y, -path.force.z};
  const Transverse& before = tank.law[tool];
  const Transverse& beyond = tank.beyond[tool];
  const Transverse ahead{0.5 * (law.y - before.y), 0.5 * (law.z - before.z)};
  const double squared = ahead.y * ahead.y + ahead.z * ahead.z;
  const double gone =
      ahead.y * (mean.y - before.y - beyond.y) + ahead.z * (mean.z - before.z - beyond.z);
  double share = gone > 0.0 && path.touched > 0 ? std::min(1.0, gone / squared) : 0.0;
  // No finger is drawn to the string.
  const double towards = -(ahead.y * mean.y + ahead.z * mean.z);
  const double all = mean.y * mean.y + mean.z * mean.z;
  if (towards * share > all) share = all / towards;
  return {mean.y + share * ahead.y, mean.z + share * ahead.z};
}

/// What each tool feels beyond its static law, on its wrench.
void give_forces(const Playing& playing, const NearTools& tools, const Touches& touches) noexcept {
  const SimulationMemory& memory = playing.wave.memory;
  WaveState& state = playing.kept.state;
  FixedVector<WavePort, kMaxTools> ports;
  double law_stored = 0.0;
  const bool parted = is_parted(playing, touches);
  bool shared_told = false;
  for (std::size_t k = 0; k < memory.tools.size(); ++k) {
    const Transverse& held = state.tank.beyond[k];
    const bool held_any = held.y != 0.0 || held.z != 0.0 || state.tank.stored[k] != 0.0;
    if (touches[k] == nullptr && !held_any) continue;
    const ToolPlay& play = memory.tools[k];
    WavePort port;
    port.tool = k;
    const ToolMotion& hand = play.way.hand;
    const Vector3 at = tools[k].proximity.p_WC;
    const bool near = touches[k] != nullptr;
    const Vector3 arm_W = near ? Vector3(at - play.rendered.X_WG.p) : Vector3::Zero();
    port.moved = across(playing.frame, hand.dp + hand.dtheta.cross(arm_W));
    if (near) {
      const StringContactPath& path = state.string.contacts[k].path;
      port.law = across(playing.frame, tools[k].proximity.F_W);
      port.felt = felt_now(path, port.law, k, state.tank);
      port.stored = law_energy(play, playing, tools[k], parted);
      if (parted && !shared_told) port.stored += shared_energy(playing);
      shared_told = true;
      const double dt = std::max(play.rendered.dt, 0.25e-3);
      port.way = across(playing.frame, dt * point_velocity(play.rendered.V_WH, arm_W));
      port.aside = playing.options.max_acceleration * dt * dt;
      law_stored += port.stored;
    }
    ports.push_back(port);
  }
  double contacts = 0.0;
  for (const WaveContact& contact : state.string.contacts) {
    if (contact.near) contacts += contact.path.stored;
  }
  const double spare = std::max(state.ringing, state.stored + contacts - law_stored);
  const std::span<const WavePort> all{ports.begin(), ports.size()};
  settle_wave_tank(all, spare, state.tank);
  std::array<Transverse, kMaxTools> beyond{};
  draw_wave_forces(all, beyond, state.tank);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (touches[ports[i].tool] == nullptr) continue;
    const std::size_t k = ports[i].tool;
    state.tank.beyond[k] = not_attracting(playing, tools[k], beyond[i]);
    add_force(playing, memory.tools[k], tools[k].proximity, state.tank.beyond[k]);
  }
}

/// Says of the events from number `first` on whose touch they are and where it is.
void name_places(const NearTools& tools, std::size_t tool, std::size_t first,
                 StringEvents& events) noexcept {
  const StringProximity& near = tools[tool].proximity;
  for (std::size_t k = first; k < events.size(); ++k) {
    StringEvent& event = events[k];
    event.tool = static_cast<std::int32_t>(tool);
    event.part = near.part;
    if (event.kind == StringEventKind::kRadius || event.kind == StringEventKind::kTone) continue;
    event.p_WC = to_array(near.p_WC);
    event.nhat_OG_W = to_array(near.nhat_W);
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
    name_places(tools, k, first, events);
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
    row.vibration_force = beyond.y * tool.touch.normal.y + beyond.z * tool.touch.normal.z;
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
  if (playing.time.dt_ns <= 0) {
    hold_forces(playing, tools, touches);
    tell(playing, tools, tick);
    return;
  }
  WaveTick stepped;
  const bool watched = std::any_of(state.grips.begin(), state.grips.end(),
                                   [](const WaveGrip& grip) { return grip.touching; });
  if (near || watched) {
    wake(playing);
    state.stepped = true;
    tune(playing, tension_of(playing, tools, touches));
    stepped =
        step(playing.string, playing.options, playing.time,
             std::span(touches).first(wave.memory.tools.size()), playing.kept.table, state.string);
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
