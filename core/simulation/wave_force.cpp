// See wave_force.h. RT: yes.
#include "core/simulation/wave_force.h"

#include <algorithm>

#include "core/contact/coupling_axes.h"
#include "core/instrument/deflection.h"
#include "core/instrument/string_model.h"
#include "core/instrument/wave_tank.h"
#include "core/simulation/wave_tension.h"

namespace hapticd {
namespace {

/// Between even ticks, s. Shorter, a hand that turns back in a long tick after a short one gets
/// what the tank has not.
constexpr double kTick = 1e-3;

/// Of the friction that the tool sticks to the string by, J: what stretches it is no heat yet.
double sticking_energy(const ToolPlay& play, std::int32_t string) noexcept {
  const TouchedStrings& touched = play.state.contact.touched;
  const int k = find_touched(touched, string);
  if (k < 0) return 0.0;
  const double slip_squared = touched[static_cast<std::size_t>(k)].slip_W.squaredNorm();
  return 0.5 * play.way.input.instrument.anchor_stiffness * slip_squared;
}

/// Of what holds the tool, J: this string's share in the coupling's, which friction stretches too,
/// and what lies between the coupling and the string.
double holding_energy(const ToolPlay& play, const Playing& playing, const NearTool& tool) noexcept {
  const ContactInput& input = play.way.input;
  const ContactState& contact = play.state.contact;
  const StringProximity& near = tool.proximity;
  const PoseError error = coupling_error(play.rendered.X_WG, input.X_WH, contact.phi_GH_W);
  const PoseError stretch = stretch_under(input.stiffness, input.X_WH.q, error, contact.F_H_W);
  const Vector3 t_W = (near.p_WC - play.rendered.X_WG.p).cross(near.F_W);
  const double coupling = -0.5 * (stretch.dp.dot(near.F_W) + stretch.dtheta.dot(t_W));
  const double softer =
      std::max(0.0, 1.0 / playing.string.contact_stiffness - 1.0 / input.stiffness.kt);
  return coupling + 0.5 * tool.touch.force * tool.touch.force * (near.compliance + softer) +
         sticking_energy(play, playing.wave.string);
}

/// Static energy of the tool's law: of the string, where it is this tool's alone, and of what holds
/// the tool, J.
double law_energy(const ToolPlay& play, const Playing& playing, const NearTool& tool,
                  bool parted) noexcept {
  if (!(tool.touch.force > 0.0)) return 0.0;
  const double held = holding_energy(play, playing, tool);
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
  const Vector3& nhat_W = tool.proximity.nhat_W;
  const Transverse n = across(playing.frame, nhat_W);
  const double across_share = n.y * n.y + n.z * n.z;
  const double law = std::min(tool.proximity.F_W.dot(nhat_W), tool.touch.force);
  const double pull = -(law + beyond.y * n.y + beyond.z * n.z);
  if (!(pull > 0.0 && across_share > 0.0)) return beyond;
  const double push = pull / across_share;
  return {beyond.y + push * n.y, beyond.z + push * n.z};
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

/// True of a tool that the last tick has held a force on, or stored energy in.
bool holds(const WaveTank& tank, std::size_t tool) noexcept {
  const Transverse& beyond = tank.beyond[tool];
  return beyond.y != 0.0 || beyond.z != 0.0 || tank.stored[tool] != 0.0;
}

/// What the string has beyond what the static laws store, J.
double spare_energy(const WaveState& state, double law_stored) noexcept {
  double contacts = 0.0;
  for (const WaveContact& contact : state.string.contacts) {
    if (contact.near) contacts += contact.path.stored;
  }
  for (const WaveRest& rest : state.string.rests) {
    if (rest.number >= 0) contacts += rest.path.stored;
  }
  return std::max(state.ringing, state.stored + contacts - law_stored);
}

/// Of a tool that is near, all but what its law stores.
WavePort port_of(const Playing& playing, const NearTool& tool, std::size_t number) noexcept {
  WaveState& state = playing.kept.state;
  const ToolPlay& play = playing.wave.memory.tools[number];
  const ToolMotion& hand = play.way.hand;
  const Vector3 arm_W = tool.proximity.p_WC - play.rendered.X_WG.p;
  WavePort port;
  port.tool = number;
  const Vector3 moved_W = hand.dp + hand.dtheta.cross(arm_W);
  const Vector3 along_W = playing.frame.axis_W.normalized();
  port.moved = across(playing.frame, moved_W);
  port.slid = moved_W.dot(along_W);
  port.law = across(playing.frame, tool.proximity.F_W);
  port.pull = tool.proximity.F_W.dot(along_W);
  // A tool that is pushed out of something feels no more than that grows by.
  const bool ramps = std::isfinite(play.state.force_bound) ||
                     play.rendered.contact.status == ContactStatus::kRecovering;
  port.felt =
      ramps ? port.law : felt_now(state.string.contacts[number].path, port.law, number, state.tank);
  // Nor does the string ring of it when that is over.
  if (ramps) state.string.motion.vy = state.string.motion.vz = PerMode{};
  // The next tick may take as long as they do, however soon this one came.
  const double dt = std::max(play.rendered.dt, kTick);
  port.way = across(playing.frame, dt * point_velocity(play.rendered.V_WH, arm_W));
  port.aside = playing.options.max_acceleration * dt * dt;
  return port;
}

}  // namespace

void hold_forces(const Playing& playing, const NearTools& tools, const Touches& touches) noexcept {
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k] == nullptr) continue;
    Transverse& beyond = playing.kept.state.tank.beyond[k];
    beyond = not_attracting(playing, tools[k], beyond);
    add_force(playing, playing.wave.memory.tools[k], tools[k].proximity, beyond);
  }
}

void give_forces(const Playing& playing, const NearTools& tools, const Touches& touches) noexcept {
  const SimulationMemory& memory = playing.wave.memory;
  WaveState& state = playing.kept.state;
  FixedVector<WavePort, kMaxTools> ports;
  const bool parted = is_parted(playing, touches);
  double law_stored = 0.0;
  for (std::size_t k = 0; k < memory.tools.size(); ++k) {
    const bool near = touches[k] != nullptr;
    if (!near && !holds(state.tank, k)) continue;
    WavePort port;
    port.tool = k;
    if (near) {
      port = port_of(playing, tools[k], k);
      port.stored = law_energy(memory.tools[k], playing, tools[k], parted);
      if (parted && law_stored == 0.0) port.stored += shared_energy(playing);
    } else {
      const Vector3& moved_W = memory.tools[k].way.hand.dp;
      port.moved = across(playing.frame, moved_W);
      port.slid = moved_W.dot(playing.frame.axis_W.normalized());
    }
    law_stored += port.stored;
    ports.push_back(port);
  }
  const std::span<const WavePort> all{ports.begin(), ports.size()};
  settle_wave_tank(all, spare_energy(state, law_stored), state.tank);
  std::array<Transverse, kMaxTools> beyond{};
  draw_wave_forces(all, state.ringing, beyond, state.tank);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const std::size_t k = ports[i].tool;
    if (touches[k] == nullptr) continue;
    state.tank.beyond[k] = not_attracting(playing, tools[k], beyond[i]);
    add_force(playing, memory.tools[k], tools[k].proximity, state.tank.beyond[k]);
  }
}

}  // namespace hapticd
