// Joins contact and strings in one tick. See simulation.h. RT: yes.
#include "core/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

/// Distance that stands for "not near", m.
constexpr double kFar = 1.0;

/// Steps towards the instant of a passage. Each about squares the error; three leave it below a
/// microsecond at any speed of a hand.
constexpr int kPassageSteps = 3;

/// The nearest listed pair of the tool, as if it stood at X_WT, and the string at rest; null when
/// none is listed.
const Contact* nearest_pair(const OptimiserInput& input, const OptimiserWorkspace& w,
                            std::int32_t string, const Pose& X_WT) noexcept {
  const Contact* nearest = nullptr;
  double gap = std::numeric_limits<double>::infinity();
  for (const Contact& listed : w.contacts.contacts) {
    if (listed.key.kind != ObstacleKind::kCapsule || listed.key.obstacle != string) continue;
    const double listed_gap = evaluate_contact(listed.key, input.tool, X_WT, input.obstacles).gap;
    if (nearest != nullptr && listed_gap >= gap) continue;
    nearest = &listed;
    gap = listed_gap;
  }
  return nearest;
}

/// From the felt surface, which is a skin above the string's, m: where a press begins from, so that
/// the distance is continuous there.
double felt_distance(double gap, const OptimiserInput& input) noexcept {
  return gap < kFar ? std::max(gap - input.options.skin, 0.0) : kFar;
}

}  // namespace

/// What the tool was asked to do in the tick, and from where.
struct Simulation::Way {
  const OptimiserInput& input;
  Pose X_WG_before;
  Pose X_WH_before;
  ToolStep hand;  ///< from X_WH_before on
};

/// Where the hand passes the surface of a string.
struct Simulation::Passage {
  double share;  ///< of the tick, in [0, 1]; negative: it does not
  Vector3 nhat_W;
  Vector3 p_HC_W;
};

/// A string as the tool stands to it.
struct Simulation::Near {
  StringTouch touch;
  Vector3 nhat_W;  ///< from string to tool
  Vector3 p_WC;
  Vector3 u_W;
};

Simulation::Simulation(const ToolScene& scene, std::span<StringTrack> tracks,
                       std::span<ModalString> modes) noexcept
    : scene_(scene), tracks_(tracks), modes_(modes) {
  HD_ASSERT(tracks.size() == scene.strings.size() &&
            scene.strings.size() <= static_cast<std::size_t>(kMaxStrings));
  HD_ASSERT(scene.instrument.modes == 0 || modes.size() == scene.strings.size());
}

// A string that swings further than the pairs of the contact problem reach, or that the tool has
// come to since they were found, has to be seen all the same. A new query, for the contact problem
// must not depend on what rings.
void Simulation::find_ringing(const Way& way, std::int64_t t_ns) noexcept {
  double swing = 0.0;
  for (const std::int32_t string : awake_) {
    const auto s = static_cast<std::size_t>(string);
    swing = std::max(swing, envelope(scene_.strings[s], tracks_[s].state,
                                     tracks_[s].state.vibration.lambda, t_ns));
  }
  if (!(swing > 0.0)) return;
  const OptimiserOptions& options = way.input.options;
  const double range = swing + options.skin + scene_.instrument.release.release_gap;
  const Pose& X_WG = tool_.optimiser.X_WG;
  const ToolStep moved = coupling_error(way.X_WG_before, X_WG, Vector3::Zero());
  const double way_gone = std::max(
      workspace_.travelled, displacement_bound(moved, tool_reach(way.input, tool_.optimiser)));
  if (range <= workspace_.contacts.covered_margin - way_gone) return;
  const double margin = std::max(options.margin, range);
  const BentObstacles bent(way.input.obstacles, tool_.optimiser.holds);
  const ToolShape shape(way.input.parts, tool_.optimiser.parts);
  find_contacts(way.input.tool, X_WG, bent.view(), {margin, margin}, workspace_.contacts,
                shape.view());
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

// The string is straight at that instant, and the hand goes evenly: a root of the gap of the pair
// that is nearest there, by false position with the Illinois rule.
void Simulation::find_passage(const Way& way, std::int32_t string, double guess,
                              Passage& passage) const noexcept {
  const auto hand = [&](double share) { return moved(way.X_WH_before, scaled(way.hand, share)); };
  const Contact* pair = nearest_pair(way.input, workspace_, string, hand(guess));
  if (pair == nullptr) return;
  const auto contact_at = [&](double share) {
    return evaluate_contact(pair->key, way.input.tool, hand(share), way.input.obstacles);
  };
  const auto gap_at = [&](double share) { return contact_at(share).gap - way.input.options.skin; };
  double from = 0.0;
  double to = 1.0;
  double gap_from = gap_at(from);
  double gap_to = gap_at(to);
  double share = guess;
  bool found = (gap_from < 0.0) != (gap_to < 0.0);
  for (int k = 0; found && k < kPassageSteps; ++k) {
    share = from + (to - from) * (gap_from / (gap_from - gap_to));
    const double gap = gap_at(share);
    if ((gap < 0.0) == (gap_to < 0.0)) {
      gap_from *= 0.5;
    } else {
      from = to;
      gap_from = gap_to;
    }
    to = share;
    gap_to = gap;
  }
  const Contact passed = contact_at(share);
  passage = {found ? share : -1.0, passed.nhat_OG_W, passed.p_WC - hand(share).p};
}

// Where the hand passes the string's surface, if it does in this tick. Before a touch the string is
// at rest; before a loss it follows the hand by its share of the displacement, or, where it slips
// off, moves as it did until then.
void Simulation::find_speeds(const Way& way, const ToolTick& tick, std::int32_t string,
                             Near& near) const noexcept {
  const StringTrack& track = tracks_[static_cast<std::size_t>(string)];
  StringTouch& touch = near.touch;
  Passage passage{-1.0, near.nhat_W, near.p_WC - tick.X_WG.p};
  if ((touch.distance_before < 0.0) != (touch.distance < 0.0)) {
    const double guess = touch.distance_before / (touch.distance_before - touch.distance);
    find_passage(way, string, guess, passage);
  }
  touch.passing = passage.share;
  const Vector3 v_WH = point_velocity(tick.V_WH, passage.p_HC_W);
  Vector3 v_WS = track.v_W;
  if (passage.share >= 0.0 && touch.distance_before < 0.0) {
    const double share = std::min(track.u_W.norm() / -touch.distance_before, 1.0);
    v_WS = share * v_WH.dot(passage.nhat_W) * passage.nhat_W;
  }
  const Vector3 v = v_WH - v_WS;
  touch.normal_speed = -v.dot(passage.nhat_W);
  touch.tangential_speed = (v + touch.normal_speed * passage.nhat_W).norm();
}

Simulation::Near Simulation::look_at(std::int32_t string, const Way& way,
                                     const ToolTick& tick) const noexcept {
  const auto s = static_cast<std::size_t>(string);
  const StringTrack& track = tracks_[s];
  const OptimiserInput& input = way.input;
  Near near{{}, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  StringTouch& touch = near.touch;
  touch.stiffness = std::min(scene_.stiffness.kt, scene_.strings[s].contact_stiffness);
  const StringContact* pressed = nullptr;
  for (const StringContact& contact : tick.strings) {
    if (contact.string == string) pressed = &contact;
  }
  if (pressed != nullptr && pressed->force > 0.0) {
    touch.distance = -pressed->displacement;
    touch.force = pressed->force;
    touch.stiffness /= 1.0 + touch.stiffness * pressed->part_compliance;
    touch.deflection = pressed->deflection;
    touch.lambda = pressed->lambda;
    near.nhat_W = pressed->nhat_W;
    near.p_WC = pressed->p_WC;
  } else {
    const StringNearness nearest =
        nearest_to_string(input, tool_.optimiser, workspace_, string, kFar);
    touch.distance = felt_distance(nearest.gap, input);
    touch.lambda = nearest.lambda;
    near.nhat_W = nearest.nhat_W;
    near.p_WC = nearest.p_WC;
  }
  touch.distance_before = track.distance;
  if (touch.distance_before >= kFar) {
    const Contact* pair = nearest_pair(input, workspace_, string, way.X_WG_before);
    if (pair != nullptr) {
      touch.distance_before = felt_distance(
          evaluate_contact(pair->key, input.tool, way.X_WG_before, input.obstacles).gap, input);
    }
  }
  for (const StringHold& hold : tool_.optimiser.holds) {
    if (hold.bend.capsule == string) near.u_W = hold.bend.u_W;
  }

  touch.way = track.nhat_W.dot(way.hand.dp + way.hand.dtheta.cross(track.p_GC_W));
  touch.hand_speed = near.nhat_W.dot(point_velocity(tick.V_WH, near.p_WC - tick.X_WG.p));
  find_speeds(way, tick, string, near);
  return near;
}

void Simulation::respond_string(std::int32_t string, const Near& near, const TickTime& time,
                                TickOutput& output) noexcept {
  const auto s = static_cast<std::size_t>(string);
  StringTrack& track = tracks_[s];
  ModalString* modes = modes_.empty() ? nullptr : &modes_[s];
  const StringResponse response = respond(scene_.strings[s], scene_.instrument, string, near.touch,
                                          time, track.state, modes, output.events);
  // What moved without time passing counts as motion of the next tick.
  if (time.dt_ns > 0) {
    track.v_W = (near.u_W - track.u_W) / (1e-9 * static_cast<double>(time.dt_ns));
    track.u_W = near.u_W;
    track.distance = near.touch.distance;
    track.nhat_W = near.nhat_W;
    track.p_GC_W = near.p_WC - output.tool.X_WG.p;
  }

  // A force held over a tick without a sample may not attract either.
  const double vibration_force = std::max(response.vibration_force, -near.touch.force);
  const Vector3 f = vibration_force * near.nhat_W;
  Wrench& F = output.tool.F_unlimited_H_W;
  F.f += f;
  F.t += (near.p_WC - output.tool.X_WG.p).cross(f);

  const StringState& state = track.state;
  if (!awake(state)) {
    track.distance = kFar;
    track.u_W = Vector3::Zero();
    track.v_W = Vector3::Zero();
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

// Only the translation: what turns the hand is small beside it.
void Simulation::damp_coupling(const Pose& X_WG_before, ToolTick& tick) const noexcept {
  if (!(scene_.coupling_damping > 0.0 && tick.dt > 0.0)) return;
  const Vector3 v_WG = (tick.X_WG.p - X_WG_before.p) / tick.dt;
  tick.F_unlimited_H_W.f -= scene_.coupling_damping * (tick.V_WH.v - v_WG);
}

void Simulation::step(const TickInput& input, TickOutput& output) noexcept {
  output.events.clear();
  output.strings.clear();
  const Pose X_WG_before = tool_.optimiser.X_WG;
  const std::int64_t t_before = tool_.guard.t_ns;
  const bool first = !tool_.guard.has_pose;
  render_contact(scene_, input.sample, tool_, workspace_, output.tool);
  if (output.tool.pose != PoseVerdict::kFault) {
    const std::int64_t t_ns = tool_.guard.t_ns;
    const TickTime time{t_ns, first ? 0 : t_ns - t_before};
    const OptimiserInput problem = optimiser_input(scene_, output.tool.X_WH, output.tool.dt);
    Way way{problem, X_WG_before, first ? output.tool.X_WH : X_WH_, {}};
    find_ringing(way, t_ns);
    merge_touched(output.tool.strings);
    if (!awake_.empty()) {
      way.hand = coupling_error(way.X_WH_before, output.tool.X_WH, Vector3::Zero());
    }
    std::size_t kept = 0;
    for (std::size_t k = 0; k < awake_.size(); ++k) {
      const std::int32_t string = awake_[k];
      respond_string(string, look_at(string, way, output.tool), time, output);
      if (awake(tracks_[static_cast<std::size_t>(string)].state)) awake_[kept++] = string;
    }
    awake_.truncate(kept);
    damp_coupling(X_WG_before, output.tool);
    if (first || time.dt_ns > 0) X_WH_ = output.tool.X_WH;
  } else {
    // Nothing was rendered, so nothing has done work.
    for (const std::int32_t string : awake_) {
      tracks_[static_cast<std::size_t>(string)].state.tank.held_force = 0.0;
    }
  }
  limit_wrench(scene_, tool_, output.tool);
}

}  // namespace hapticd
