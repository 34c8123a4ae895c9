// See string_proximity.h. RT: yes.
#include "core/simulation/string_proximity.h"

#include <algorithm>
#include <limits>

#include "core/contact/clearance.h"

namespace hapticd {
namespace {

/// Steps towards the instant of a passage. Each about squares the error; three leave it below a
/// microsecond at any speed of a hand.
constexpr int kPassageSteps = 3;

/// Where the hand passes the surface of a string.
struct Passage {
  double share;  ///< of the tick, in [0, 1]; negative: it does not
  Vector3 nhat_W;
  Vector3 p_HC_W;
};

/// The nearest listed pair of the tool, as if it stood at X_WT, and the string at rest; null when
/// none is listed.
const Contact* nearest_pair(const ToolPlay& play, std::int32_t string, const Pose& X_WT) noexcept {
  const ContactInput& input = play.way.input;
  const Contact* nearest = nullptr;
  double gap = std::numeric_limits<double>::infinity();
  for (const Contact& listed : string_pairs(play).contacts) {
    if (!is_string(listed.key) || listed.key.obstacle != string) continue;
    const double listed_gap = evaluate_contact(listed.key, {input.tool, X_WT}, input.obstacles).gap;
    if (nearest != nullptr && listed_gap >= gap) continue;
    nearest = &listed;
    gap = listed_gap;
  }
  return nearest;
}

/// Of a vertex from the straight string.
Vector3 whole_deflection(const ToolPlay& play, const StringBend& bend) noexcept {
  const StringPart* part = part_of(play.view, bend.capsule);
  if (part == nullptr) return bend.u_W;
  const auto string = static_cast<std::size_t>(bend.capsule);
  const Capsule& line = play.scene.obstacles.capsules_W[string];
  const Vector3 p_P = leg_of(part->part_W, bend, 0).capsule_W.p_B;
  return p_P - (line.p_A + lambda_of(line, p_P) * (line.p_B - line.p_A));
}

/// Of the hand from the string, which a tool in motion stands off by its clearance, m: a press
/// begins at 0, so that the distance is continuous there.
double felt_distance(double gap, const ContactState& state) noexcept {
  return gap < kNotNear ? std::max(gap - state.clearance, 0.0) : kNotNear;
}

/// The string is straight at that instant, and the hand goes evenly: a root of the gap of the pair
/// that is nearest there, by false position with the Illinois rule.
void find_passage(const ToolPlay& play, std::int32_t string, double guess,
                  Passage& passage) noexcept {
  const ToolWay& way = play.way;
  const auto hand = [&](double share) { return moved(way.X_WH_before, scaled(way.hand, share)); };
  const Contact* pair = nearest_pair(play, string, hand(guess));
  if (pair == nullptr) return;
  const auto contact_at = [&](double share) {
    return evaluate_contact(pair->key, {way.input.tool, hand(share)}, way.input.obstacles);
  };
  const auto gap_at = [&](double share) { return contact_at(share).gap; };
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

/// Where the hand passes the string's surface, if it does in this tick. Before a touch the string
/// is at rest; before a loss it follows the hand by its share of the displacement, or, where it
/// slips off, moves as it did until then.
void find_speeds(const ToolPlay& play, const ToolStringState& visit, std::int32_t string,
                 StringProximity& near) noexcept {
  StringTouch& touch = near.touch;
  Passage passage{-1.0, near.nhat_W, near.p_WC - play.rendered.X_WG.p};
  if ((touch.distance_before < 0.0) != (touch.distance < 0.0)) {
    const double guess = touch.distance_before / (touch.distance_before - touch.distance);
    find_passage(play, string, guess, passage);
  }
  touch.passing = passage.share;
  const Vector3 v_WH = point_velocity(play.rendered.V_WH, passage.p_HC_W);
  Vector3 v_WS = visit.v_W;
  if (passage.share >= 0.0 && touch.distance_before < 0.0) {
    const double share = std::min(visit.u_W.norm() / -touch.distance_before, 1.0);
    v_WS = share * v_WH.dot(passage.nhat_W) * passage.nhat_W;
  }
  const Vector3 v = v_WH - v_WS;
  touch.normal_speed = -v.dot(passage.nhat_W);
  touch.tangential_speed = (v + touch.normal_speed * passage.nhat_W).norm();
}

}  // namespace

StringProximity proximity_to(const ToolPlay& play, const ToolStringState& visit,
                             std::int32_t string) noexcept {
  const ContactInput& input = play.way.input;
  const ContactState& state = play.state.contact;
  const RenderedTool& tick = play.rendered;
  StringProximity near;
  StringTouch& touch = near.touch;
  touch.time = play.way.time;
  touch.stiffness = std::min(input.stiffness.kt,
                             input.strings[static_cast<std::size_t>(string)].contact_stiffness);
  const PressedString* pressed = nullptr;
  for (const PressedString& contact : tick.strings) {
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
    near.part = pressed->part;
    near.radius = pressed->radius;
    near.compliance = pressed->part_compliance;
    near.F_W = pressed->F_W;
  } else {
    touch.distance = kNotNear;
    touch.lambda = 0.5;
    const auto nearest = nearest_to_string({input, state}, string_pairs(play), string);
    if (nearest && nearest->gap < kNotNear) {
      touch.distance = felt_distance(nearest->gap, state);
      touch.lambda = nearest->lambda;
      near.nhat_W = nearest->nhat_W;
      near.p_WC = nearest->p_WC;
      near.part = nearest->part;
      near.radius = nearest->radius;
    }
  }
  touch.distance_before = visit.distance;
  if (touch.distance_before >= kNotNear) {
    const Contact* pair = nearest_pair(play, string, play.way.X_WG_before);
    if (pair != nullptr) {
      touch.distance_before = felt_distance(
          evaluate_contact(pair->key, {input.tool, play.way.X_WG_before}, input.obstacles).gap,
          state);
    }
  }
  for (const TouchedString& hold : state.touched) {
    if (hold.bend.capsule != string) continue;
    StringBend felt = hold.bend;
    felt.u_W = hold.u_felt_W;
    near.u_W = whole_deflection(play, felt);
  }

  touch.way = visit.nhat_W.dot(play.way.hand.dp);
  touch.hand_speed = near.nhat_W.dot(point_velocity(tick.V_WH, near.p_WC - tick.X_WG.p));
  find_speeds(play, visit, string, near);
  return near;
}

// A query of its own, for the contact problem must not depend on what rings; bodies do not ring.
void reach_out(double swing, ToolPlay& play) noexcept {
  const ContactInput& input = play.way.input;
  const ContactOptions& options = input.options;
  const ContactState& state = play.state.contact;
  const double range = swing + skin_of(options) + input.instrument.release.release_gap;
  const ToolMotion moved = motion_between(play.way.X_WG_before, state.X_WG);
  const double travel = displacement_bound(moved, tool_reach({input, state}));
  play.reached_out = !play.problem.candidates().sees(range, travel);
  if (!play.reached_out) return;
  const double margin = std::max(options.margin, range);
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  const ObstaclesView all = bent.view();
  const ObstaclesView strings{all.capsules_W, {}, all.bends, all.groups, all.all};
  find_contacts({input.tool, state.X_WG, shape.view()}, strings, {margin, margin}, play.swung);
}

}  // namespace hapticd
