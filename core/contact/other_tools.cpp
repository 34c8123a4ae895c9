// See other_tools.h. RT: yes.
#include "core/contact/other_tools.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// What may hide between two places of a way that are looked at, m.
constexpr double kHidden = 0.25e-6;
/// Places looked at in a way, at most: what needs more is refused, and tried anew half as long.
constexpr double kMaxPlaces = 256.0;

/// A string on its way.
struct StringTravel {
  const Capsule& straight_W;
  const StringBend& bend;
  const StringMotion& motion;
  double travel;  ///< of any of its points, at most, m
};

/// False when no point of the string can reach the tool.
bool may_meet(const OtherTool& other, const StringTravel& string) noexcept {
  const double room =
      reach(other.tool) + greatest_displacement(*other.soft) + string.straight_W.r + string.travel;
  for (const std::int32_t leg : {0, 1}) {
    const Capsule axis = leg_of(string.straight_W, string.bend, leg).capsule_W;
    if (closest_point_on_segment(axis.p_A, axis.p_B, other.X_WG.p).distance <=
        room + kOtherToolClearance)
      return true;
  }
  return false;
}

/// Places to look at so that no more than kHidden hides between two: a point that goes straight
/// comes nearer to a centre at distance d by (travel / n)^2 / (8 d) at most.
double places_of(const OtherTool& other, const ContactSet& pairs,
                 const StringTravel& string) noexcept {
  double d = std::numeric_limits<double>::infinity();
  for (const Contact& pair : pairs.contacts) {
    d = std::min(d, string.straight_W.r + tree_sphere(other.tool, pair.key.tool_sphere).r);
  }
  return std::ceil(string.travel / std::sqrt(8.0 * d * kHidden));
}

bool clear_of(const OtherTool& other, ContactSet& pairs, const StringTravel& string) noexcept {
  if (!may_meet(other, string)) return true;
  const double margin = string.travel + kOtherToolClearance;
  StringBend alone = string.bend;
  alone.capsule = 0;
  const std::span<const Capsule> capsules(&string.straight_W, 1);
  const ToolShape shape(other.parts, *other.soft);
  find_contacts({other.tool, other.X_WG, shape.view()}, {capsules, {}, {&alone, 1}},
                {margin, margin}, pairs);
  if (pairs.contacts.empty()) return true;
  if (pairs.covered_margin < margin) return false;
  const double wanted = places_of(other, pairs, string);
  if (wanted > kMaxPlaces) return false;
  const int places = std::max(static_cast<int>(wanted), 1);
  for (int place = places; place > 0; --place) {
    StringBend there =
        moved(string.bend, scaled(string.motion, static_cast<double>(place) / places));
    there.capsule = 0;
    for (const Contact& pair : pairs.contacts) {
      const double gap = evaluate_contact(pair.key, {other.tool, other.X_WG, shape.view()},
                                          {capsules, {}, {&there, 1}})
                             .gap;
      if (gap < std::min(pair.gap, kOtherToolClearance)) return false;
    }
  }
  return true;
}

}  // namespace

bool clear_of_other_tools(const OtherTools& others, const Capsule& straight_W,
                          const StringBend& bend, const StringMotion& motion) noexcept {
  if (others.tools.empty()) return true;
  const double length = (straight_W.p_B - straight_W.p_A).norm();
  const double travel = displacement_bound(motion, length);
  if (!(travel > 0.0)) return true;
  for (const OtherTool& other : others.tools) {
    if (!clear_of(other, *others.scratch, {straight_W, bend, motion, travel})) return false;
  }
  return true;
}

}  // namespace hapticd
