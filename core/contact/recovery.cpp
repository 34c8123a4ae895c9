// Finds the way out of an overlap. See recovery.h. RT: yes.
#include "core/contact/recovery.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Contacts within this share of the greatest depth count as equally deep. Larger: smoother, less
/// direct ways out.
constexpr double kEquallyDeep = 0.1;
/// Overlaps up to this are rounding: the pair counts as open, m. Larger: a true overlap as shallow
/// as this is not pushed deeper to undo another; smaller: the tool may slip into what it touches.
constexpr double kTouching = 1e-9;
/// What a push along a surface may take of a gap without room, m: far above the rounding of its
/// direction, far below any length that matters.
constexpr double kGrazing = 1e-15;
/// A push shorter than this is blocked, m.
constexpr double kMinPush = 1e-9;

/// Shortest translation that clears every penetrated pair to first order and keeps the others;
/// false when there is none.
bool program_direction(const ContactInput& input, OptimiserWorkspace& w, Vector3& dp) noexcept {
  w.problem.unknowns = 3;
  w.problem.rows = 0;
  w.problem.weight.fill(1.0);
  w.problem.target.fill(0.0);
  for (const Contact& contact : w.contacts.contacts) {
    if (w.problem.rows == input.options.max_rows) break;
    const auto i = static_cast<std::size_t>(w.problem.rows++);
    for (std::size_t k = 0; k < 3; ++k) {
      w.problem.row[k][i] = contact.nhat_OG_W[static_cast<Eigen::Index>(k)];
    }
    w.problem.bound[i] = contact.gap < 0.0 ? input.options.skin - contact.gap
                                           : std::min(0.0, input.options.skin - contact.gap);
  }
  solve_qp(w.problem, QpWarmStart{}, w.qp, w.solution);
  dp = {w.solution.x[0], w.solution.x[1], w.solution.x[2]};
  return w.solution.status == QpStatus::kOptimal;
}

/// Sum of the normals of the deepest contacts, scaled to the greatest depth; or the deepest normal
/// alone.
Vector3 deepest_direction(const ContactSet& set, bool only_deepest, double skin) noexcept {
  Vector3 sum = Vector3::Zero();
  HD_ASSERT(!set.contacts.empty());
  const Contact* deepest = set.contacts.begin();
  for (const Contact& contact : set.contacts) {
    if (contact.gap < deepest->gap) deepest = &contact;
    if (contact.gap <= (1.0 - kEquallyDeep) * set.minimum_gap) sum += contact.nhat_OG_W;
  }
  const double depth = skin - set.minimum_gap;
  const double length = sum.norm();
  if (only_deepest || !(length > 0.0)) return deepest->nhat_OG_W * depth;
  return sum * (depth / length);
}

/// Largest length up to `limit` along the unit vector `way` that leaves open gaps at the skin or as
/// they are: the distance to a convex obstacle never falls below its tangent, and what the query
/// left out is farther than its margin.
double open_length(const ContactSet& set, const Vector3& way, double limit, double skin) noexcept {
  double length = limit;
  if (set.covered_margin > 0.0) length = std::min(length, set.covered_margin);
  for (const Contact& contact : set.contacts) {
    if (contact.gap < -kTouching) continue;
    const double approach = -contact.nhat_OG_W.dot(way);
    const double room = std::max(contact.gap - skin, kGrazing);
    if (approach * length > room) length = room / approach;
  }
  return length;
}

/// Commits the translation, cut to the recovery speed and to open gaps, when it enlarges the
/// minimum gap.
bool push(const ContactInput& input, const Vector3& dp, ContactState& state, OptimiserWorkspace& w,
          ContactResult& result) noexcept {
  const double wanted = dp.norm();
  if (!(wanted > 0.0)) return false;
  const Vector3 way = dp / wanted;
  const double limit = std::min(wanted, input.options.recovery_speed * input.dt);
  const double length = open_length(w.contacts, way, limit, input.options.skin);
  if (length < kMinPush) return false;
  const ToolMotion step{way * length, Vector3::Zero()};
  const Pose X_new = moved(state.X_WG, step);
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  const double gap = minimum_gap_of(w.contacts, input.tool, X_new, bent.view(), shape.view());
  if (!(gap > w.contacts.minimum_gap)) return false;
  state.X_WG = X_new;
  result.minimum_gap = gap;
  return true;
}

}  // namespace

void recover(const ContactInput& input, ContactState& state, OptimiserWorkspace& w,
             ContactResult& result) noexcept {
  result.status = ContactStatus::kRecovering;
  result.sub_steps = 1;
  const double skin = input.options.skin;
  Vector3 dp;
  const bool planned = program_direction(input, w, dp);
  result.qp_iterations += w.solution.iterations;
  result.rows += w.problem.rows;
  if (!(planned && push(input, dp, state, w, result)) &&
      !push(input, deepest_direction(w.contacts, false, skin), state, w, result)) {
    static_cast<void>(push(input, deepest_direction(w.contacts, true, skin), state, w, result));
  }
  const PoseError error_GH = coupling_error(state.X_WG, input.X_WH, state.phi_GH_W);
  state.phi_GH_W = error_GH.dtheta;
  state.active_count = 0;
  state.F_H_W = {input.stiffness.kt * -error_GH.dp, input.stiffness.kr() * -error_GH.dtheta};
  result.F_H_W = state.F_H_W;
}

}  // namespace hapticd
