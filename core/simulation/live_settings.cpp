// See live_settings.h. RT: yes.
#include "core/simulation/live_settings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/contact/coupling_axes.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Below this a force is nothing, N: a tension or stretch that gives less goes straight to 0.
/// Smaller: a string takes longer to go slack; larger: its last bit of force comes as a step.
constexpr double kNoForce = 1e-3;
/// Likewise of a coefficient of friction, and of a force gain.
constexpr double kNoFriction = 1e-3;
constexpr double kNoGain = 1e-2;
/// Haptic displacement per metre below which any string is a wall.
constexpr double kWall = 1e-9;

/// Force follows a coefficient of friction in this power, at most, where a string slips: it yields
/// the more the less holds it.
constexpr double kFrictionPower = 2.0;
/// Cross section below which stretching a string gives no force, m^2.
constexpr double kSmallestArea = 1e-18;

double between(double from, double to, double share) noexcept {
  return share >= 1.0 ? to : from + share * (to - from);
}

/// Normalised straight line between orientations, the short way.
Quaternion between(const Quaternion& from, const Quaternion& to, double share) noexcept {
  if (share >= 1.0) return to;
  const double sign = from.dot(to) < 0.0 ? -1.0 : 1.0;
  return renormalised(Quaternion((1.0 - share) * from.coeffs() + (sign * share) * to.coeffs()));
}

/// A number >= 0 that goes by equal factors above `floor`, and straight below it.
struct Scale {
  double floor;
  double power;                                           ///< with which force follows it, at most
  bool edged = false;                                     ///< its law has an edge
  double most = std::numeric_limits<double>::infinity();  ///< above it nothing changes
};

double between(const Scale& scale, double from, double to, double share) noexcept {
  if (share >= 1.0 || from == to) return to;
  const double a = std::min(from, scale.most);
  const double b = std::min(to, scale.most);
  if (a == b) return to;
  const double now = blend_scale(a + scale.floor, b + scale.floor, share) - scale.floor;
  return std::clamp(now, std::min(a, b), std::max(a, b));
}

/// Longer by the way of one scale.
void lengthen(const Scale& scale, double from, double to, WayLength& length) noexcept {
  const double a = std::min(from, scale.most) + scale.floor;
  const double b = std::min(to, scale.most) + scale.floor;
  if (a == b) return;
  const double logs = scale.power * std::abs(logarithm(b) - logarithm(a));
  length.most = std::max(length.most, logs);
  if (scale.edged) length.edged = std::max(length.edged, logs);
}

/// Calls `visit` for each scale that force follows, with its member.
template <typename Visit>
void visit_scales(Visit&& visit) noexcept {
  visit(
      Scale{0.0, 1.0}, [](auto& live) -> auto& { return live.coupling.kt; });
  // kr is its square.
  visit(
      Scale{0.0, 2.0}, [](auto& live) -> auto& { return live.coupling.length; });
  visit(
      Scale{kNoGain, 1.0}, [](auto& live) -> auto& { return live.force_gain; });
  visit(
      Scale{0.0, 1.0}, [](auto& live) -> auto& { return live.scale; });
  visit(
      Scale{0.0, 1.0}, [](auto& live) -> auto& { return live.instrument.anchor_stiffness; });
}

/// Shares of axes go by equal factors, too, so that each axis does.
void blend_axes(const CouplingStiffness& from, const CouplingStiffness& to, double share,
                CouplingStiffness& now) noexcept {
  now.per_axis = share >= 1.0 ? to.per_axis : from.per_axis || to.per_axis;
  if (share >= 1.0 || !now.per_axis) return;
  for (Eigen::Index k = 0; k < 3; ++k) {
    now.shares.along_W[k] = blend_scale(from.shares.along_W[k], to.shares.along_W[k], share);
    now.shares.about_G[k] = blend_scale(from.shares.about_G[k], to.shares.about_G[k], share);
  }
  now = normalised(now);
}

/// Longer by the way of the axis that goes farthest.
void lengthen(const CouplingStiffness& from, const CouplingStiffness& to,
              WayLength& length) noexcept {
  if (!from.per_axis && !to.per_axis) return;
  const Scale axis{0.0, 1.0};
  for (Eigen::Index k = 0; k < 3; ++k) {
    lengthen(axis, from.along_W()[k], to.along_W()[k], length);
    lengthen(axis, from.about_G()[k], to.about_G()[k], length);
  }
}

/// Likewise of a string. A straight one gives the smallest of what is pressed, what its law gives
/// and what kc gives; the law follows what is pressed over k_s in the third power.
template <typename Visit>
void visit_scales(const StringParameters& string, double stiffest, Visit&& visit) noexcept {
  const bool straight = string.model == StringContact::kStraight;
  const double area = std::max(kPi * string.radius * string.radius, kSmallestArea);
  visit(Scale{kNoForce, 1.0, straight}, &StringParameters::tension);
  visit(Scale{kNoForce / area, 1.0, straight}, &StringParameters::youngs_modulus);
  visit(Scale{kNoForce, 1.0, straight}, &StringParameters::axial_stiffness);
  visit(Scale{kWall, straight ? 3.0 : 0.0, straight}, &StringParameters::k_s);
  visit(Scale{0.0, 1.0, straight, stiffest}, &StringParameters::contact_stiffness);
  visit(Scale{kNoFriction, kFrictionPower, true}, &StringParameters::friction_coefficient);
  visit(Scale{0.0, 0.0}, &StringParameters::decay);
  visit(Scale{0.0, 0.0}, &StringParameters::touch_decay);
}

/// Both with E A as a number of their own, where one of them has it and they are not alike.
struct StringWay {
  StringParameters from;
  StringParameters to;

  StringWay(const StringParameters& a, const StringParameters& b) noexcept : from(a), to(b) {
    if (from.axial_stiffness == to.axial_stiffness) return;
    from.axial_stiffness = axial_stiffness_of(a);
    to.axial_stiffness = axial_stiffness_of(b);
  }
};

}  // namespace

double blend_scale(double from, double to, double share) noexcept {
  if (share >= 1.0 || from == to) return to;
  const double start = logarithm(from);
  return exponential(start + share * (logarithm(to) - start));
}

LiveSettings blend(const LiveSettings& from, const LiveSettings& to, double share) noexcept {
  LiveSettings now = to;
  visit_scales(
      [&](const Scale& scale, auto of) { of(now) = between(scale, of(from), of(to), share); });
  blend_axes(from.coupling, to.coupling, share, now.coupling);
  now.coupling_damping = between(from.coupling_damping, to.coupling_damping, share);
  now.X_WD.p = share >= 1.0 ? to.X_WD.p : Vector3(from.X_WD.p + share * (to.X_WD.p - from.X_WD.p));
  now.X_WD.q = between(from.X_WD.q, to.X_WD.q, share);
  // Straight, both: so the margin stays above the skin.
  now.contact.margin = between(from.contact.margin, to.contact.margin, share);
  now.contact.skin = between(from.contact.skin, to.contact.skin, share);
  return now;
}

StringParameters StringBlend::operator()(const StringParameters& old,
                                         const StringParameters& next) noexcept {
  if (share_ >= 1.0) return next;
  const StringWay way(old, next);
  const StringParameters& from = way.from;
  const StringParameters& to = way.to;
  StringParameters now = to;
  std::size_t number = 0;
  const auto go = [&](const Scale& scale, double StringParameters::*member) {
    ScaleWay& last = last_[number++];
    if (from.*member == to.*member) return;
    if (last.floor != scale.floor || last.from != from.*member || last.to != to.*member) {
      last = {scale.floor, from.*member, to.*member,
              between(scale, from.*member, to.*member, share_)};
    }
    now.*member = last.now;
  };
  visit_scales(to, stiffest_, go);
  // A tuning that comes or goes has nothing to glide from.
  if (from.frequency > 0.0 && to.frequency > 0.0) {
    go(Scale{0.0, 0.0}, &StringParameters::frequency);
  }
  return now;
}

WayLength way_length(const LiveSettings& from, const LiveSettings& to) noexcept {
  WayLength length;
  visit_scales([&](const Scale& scale, auto of) { lengthen(scale, of(from), of(to), length); });
  lengthen(from.coupling, to.coupling, length);
  return length;
}

WayLength way_length(const StringParameters& old, const StringParameters& next,
                     double stiffest) noexcept {
  const StringWay way(old, next);
  const StringParameters& from = way.from;
  const StringParameters& to = way.to;
  WayLength length;
  visit_scales(to, stiffest, [&](const Scale& scale, double StringParameters::*member) {
    lengthen(scale, from.*member, to.*member, length);
  });
  return length;
}

double ramp_time(const WayLength& length) noexcept {
  return std::max(kSettingsRamp_s, length.most / kScalePace);
}

}  // namespace hapticd
