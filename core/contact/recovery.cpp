// Finds the way out of an overlap. See recovery.h. RT: yes.
#include "core/contact/recovery.h"

#include <algorithm>

#include "core/contact/clearance.h"

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

/// Largest length up to `limit` along the unit vector `direction` that leaves open gaps at the skin
/// or as they are: the distance to a convex obstacle never falls below its tangent, and what the
/// query left out is farther than its margin.
double open_length(const ContactSet& set, const Vector3& direction, double limit,
                   double skin) noexcept {
  double length = limit;
  if (set.covered_margin > 0.0) length = std::min(length, set.covered_margin);
  for (const Contact& contact : set.contacts) {
    if (contact.gap < -kTouching) continue;
    const double approach = -contact.nhat_OG_W.dot(direction);
    const double room = std::max(contact.gap - skin, kGrazing);
    if (approach * length > room) length = room / approach;
  }
  return length;
}

}  // namespace

Vector3 deepest_direction(const ContactSet& contacts, bool only_deepest, double skin) noexcept {
  Vector3 sum = Vector3::Zero();
  HD_ASSERT(!contacts.contacts.empty());
  const Contact* deepest = contacts.contacts.begin();
  for (const Contact& contact : contacts.contacts) {
    if (contact.gap < deepest->gap) deepest = &contact;
    if (contact.gap <= (1.0 - kEquallyDeep) * contacts.minimum_gap) sum += contact.nhat_OG_W;
  }
  const double depth = skin - contacts.minimum_gap;
  const double length = sum.norm();
  if (only_deepest || !(length > 0.0)) return deepest->nhat_OG_W * depth;
  return sum * (depth / length);
}

std::optional<Push> push_out(const Configuration& at, const ContactSet& contacts,
                             const Vector3& dp_W) noexcept {
  const auto& [input, state] = at;
  const double wanted = dp_W.norm();
  if (!(wanted > 0.0)) return std::nullopt;
  const Vector3 direction = dp_W / wanted;
  const double limit = std::min(wanted, input.options.recovery_speed * input.dt);
  const double length = open_length(contacts, direction, limit, skin_of(input.options));
  if (length < kMinPush) return std::nullopt;
  const Pose X_WG = moved(state.X_WG, {direction * length, Vector3::Zero()});
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  const double gap = minimum_gap_of(contacts, {input.tool, X_WG, shape.view()}, bent.view());
  if (!(gap > contacts.minimum_gap)) return std::nullopt;
  return Push{X_WG, gap};
}

}  // namespace hapticd
