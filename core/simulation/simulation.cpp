// Joins contact and strings in one tick. See simulation.h. RT: yes.
#include "core/simulation/simulation.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/// Distance that stands for "not near", m.
constexpr double kFar = 1.0;

/// Where the tool's surface was against the resting string at the start of the tick, for a touch
/// that begins in it: of the pairs that touch now, m.
double distance_before(const OptimiserInput& input, const OptimiserWorkspace& w,
                       const OptimiserResult& result, std::int32_t string,
                       const Pose& X_before) noexcept {
  double gap = kFar;
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact& active = result.active[static_cast<std::size_t>(k)];
    const ContactKey& key = w.contacts.contacts[static_cast<std::size_t>(active.contact)].key;
    if (key.kind != ObstacleKind::kCapsule || key.obstacle != string) continue;
    gap = std::min(gap, evaluate_contact(key, input.tool, X_before, input.obstacles).gap);
  }
  return std::max(gap, 0.0);
}

}  // namespace

/// A string as the tool stands to it.
struct Simulation::Near {
  StringTouch touch;
  Vector3 nhat_W;  ///< from string to tool
  Vector3 p_WC;
  Vector3 u_W;
};

Simulation::Simulation(const ToolScene& scene, std::span<StringTrack> tracks,
                       std::span<ModalString> modes) noexcept
    : scene_(scene), margin_(scene.options.margin), tracks_(tracks), modes_(modes) {
  HD_ASSERT(tracks.size() == scene.strings.size() &&
            scene.strings.size() <= static_cast<std::size_t>(kMaxStrings));
  HD_ASSERT(scene.instrument.modes == 0 || modes.size() == scene.strings.size());
}

// A string that swings further than the margin has to be seen in time.
void Simulation::set_margin(std::int64_t t_ns) noexcept {
  double reach = 0.0;
  for (const std::int32_t string : awake_) {
    const auto s = static_cast<std::size_t>(string);
    reach = std::max(reach, envelope(scene_.strings[s], tracks_[s].state,
                                     tracks_[s].state.vibration.lambda, t_ns));
  }
  scene_.options.margin = std::max(margin_, reach + scene_.instrument.release.release_gap);
}

void Simulation::merge_touched(const StringContacts& touched) noexcept {
  for (const StringContact& contact : touched) {
    const auto* const at = std::lower_bound(awake_.begin(), awake_.end(), contact.string);
    if (at != awake_.end() && *at == contact.string) continue;
    const auto index = static_cast<std::size_t>(at - awake_.begin());
    if (!awake_.push_back(contact.string)) return;
    std::rotate(awake_.begin() + index, awake_.end() - 1, awake_.end());
  }
}

Simulation::Near Simulation::look_at(std::int32_t string, const OptimiserInput& input,
                                     const Pose& X_before, const ToolTick& tick) const noexcept {
  const auto s = static_cast<std::size_t>(string);
  const StringTrack& track = tracks_[s];
  Near near{{}, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  StringTouch& touch = near.touch;
  touch.stiffness = std::min(scene_.stiffness.kt, scene_.strings[s].contact_stiffness);
  touch.distance_before = track.distance;
  const StringContact* pressed = nullptr;
  for (const StringContact& contact : tick.strings) {
    if (contact.string == string) pressed = &contact;
  }
  if (pressed != nullptr && pressed->force > 0.0) {
    touch.distance = -pressed->displacement;
    touch.force = pressed->force;
    touch.deflection = pressed->deflection;
    touch.lambda = pressed->lambda;
    near.nhat_W = pressed->nhat_W;
    near.p_WC = pressed->p_WC;
    if (!awake(track.state)) {
      touch.distance_before = distance_before(input, workspace_, tick.optimiser, string, X_before);
    }
  } else {
    const StringNearness nearest =
        nearest_to_string(input, tool_.optimiser, workspace_, string, kFar);
    touch.distance = nearest.gap;
    touch.lambda = nearest.lambda;
    near.nhat_W = nearest.nhat_W;
    near.p_WC = nearest.p_WC;
  }
  for (const StringHold& hold : tool_.optimiser.holds) {
    if (hold.bend.capsule == string) near.u_W = hold.bend.u_W;
  }
  // Against the string as it moved until now: at rest before a touch, with the finger before a
  // loss.
  const Vector3 v = point_velocity(tick.V_WH, near.p_WC - tick.X_WH.p) - track.v_W;
  touch.normal_speed = -v.dot(near.nhat_W);
  touch.tangential_speed = (v + touch.normal_speed * near.nhat_W).norm();
  return near;
}

void Simulation::respond_string(std::int32_t string, const Near& near, const TickTime& time,
                                TickOutput& output) noexcept {
  const auto s = static_cast<std::size_t>(string);
  StringTrack& track = tracks_[s];
  ModalString* modes = modes_.empty() ? nullptr : &modes_[s];
  const StringResponse response = respond(scene_.strings[s], scene_.instrument, string, near.touch,
                                          time, track.state, modes, output.events);
  const double dt = 1e-9 * static_cast<double>(time.dt_ns);
  track.v_W = dt > 0.0 ? Vector3((near.u_W - track.u_W) / dt) : track.v_W;
  track.u_W = near.u_W;
  track.distance = near.touch.distance;

  // A force held over a tick without a sample may not attract either.
  const double vibration_force = std::max(response.vibration_force, -near.touch.force);
  const Vector3 f = vibration_force * near.nhat_W;
  Wrench& F = output.tool.F_unlimited_H_W;
  F.f += f;
  F.t += (near.p_WC - output.tool.X_WG.p).cross(f);

  const StringState& state = track.state;
  if (!awake(state)) {
    track.distance = kFar;
    return;
  }
  StringReading reading;
  reading.string = string;
  reading.level = state.level;
  reading.touched = state.detector.touching;
  reading.armed = state.detector.armed;
  reading.lambda = reading.touched ? near.touch.lambda : state.vibration.lambda;
  reading.radius_growth = response.radius_growth;
  reading.vibration_force = vibration_force;
  reading.deflection_W = near.u_W;
  output.strings.push_back(reading);
}

void Simulation::step(const TickInput& input, TickOutput& output) noexcept {
  output.events.clear();
  output.strings.clear();
  const Pose X_before = tool_.optimiser.X_WG;
  const std::int64_t t_before = tool_.guard.t_ns;
  const bool first = !tool_.guard.has_pose;
  set_margin(t_before);
  render_contact(scene_, input.sample, tool_, workspace_, output.tool);
  if (output.tool.pose != PoseVerdict::kFault) {
    const std::int64_t t_ns = tool_.guard.t_ns;
    const TickTime time{t_ns, first ? 0 : t_ns - t_before};
    const OptimiserInput problem = optimiser_input(scene_, output.tool.X_WH, output.tool.dt);
    merge_touched(output.tool.strings);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < awake_.size(); ++k) {
      const std::int32_t string = awake_[k];
      respond_string(string, look_at(string, problem, X_before, output.tool), time, output);
      if (awake(tracks_[static_cast<std::size_t>(string)].state)) awake_[kept++] = string;
    }
    awake_.truncate(kept);
  }
  limit_wrench(scene_, tool_, output.tool);
}

}  // namespace hapticd
