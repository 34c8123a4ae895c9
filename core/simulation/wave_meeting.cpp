// See wave_meeting.h. RT: yes.
#include "core/simulation/wave_meeting.h"

#include <algorithm>

#include "core/contact/coupling_axes.h"
#include "core/instrument/wave_string.h"

namespace hapticd {
namespace {

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
  touch.law = across(frame, near.F_W);
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
  // A tool on top of a fret bends nothing itself.
  const bool bends = near.u_W.squaredNorm() > 0.0;
  if (touch.force > 0.0 && bends) {
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

}  // namespace

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

const StringConstants& constants_of(const SimulationMemory& memory, std::int32_t string) noexcept {
  return memory.tools.front().scene.strings[static_cast<std::size_t>(string)];
}

WaveMemory& kept_of(const SimulationMemory& memory, std::int32_t string) noexcept {
  return memory.waves[static_cast<std::size_t>(string)];
}

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

}  // namespace hapticd
