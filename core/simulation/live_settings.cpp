// See live_settings.h. RT: yes.
#include "core/simulation/live_settings.h"

#include <algorithm>

namespace hapticd {
namespace {

double between(double from, double to, double share) noexcept {
  return share >= 1.0 ? to : from + share * (to - from);
}

/// Normalised straight line between orientations, the short way.
Quaternion between(const Quaternion& from, const Quaternion& to, double share) noexcept {
  if (share >= 1.0) return to;
  const double sign = from.dot(to) < 0.0 ? -1.0 : 1.0;
  return renormalised(Quaternion((1.0 - share) * from.coeffs() + (sign * share) * to.coeffs()));
}

}  // namespace

LiveSettings blend(const LiveSettings& from, const LiveSettings& to, double share) noexcept {
  LiveSettings now = to;
  const auto go = [&](auto member) { now.*member = between(from.*member, to.*member, share); };
  now.coupling.kt = between(from.coupling.kt, to.coupling.kt, share);
  now.coupling.length = between(from.coupling.length, to.coupling.length, share);
  go(&LiveSettings::coupling_damping);
  go(&LiveSettings::force_gain);
  go(&LiveSettings::scale);
  now.X_WD.p = share >= 1.0 ? to.X_WD.p : Vector3(from.X_WD.p + share * (to.X_WD.p - from.X_WD.p));
  now.X_WD.q = between(from.X_WD.q, to.X_WD.q, share);
  now.contact.margin = between(from.contact.margin, to.contact.margin, share);
  now.contact.skin = between(from.contact.skin, to.contact.skin, share);
  return now;
}

StringParameters blend(const StringParameters& from, const StringParameters& to,
                       double share) noexcept {
  StringParameters now = to;
  const auto go = [&](auto member) { now.*member = between(from.*member, to.*member, share); };
  go(&StringParameters::tension);
  go(&StringParameters::youngs_modulus);
  go(&StringParameters::decay);
  go(&StringParameters::touch_decay);
  go(&StringParameters::k_s);
  go(&StringParameters::contact_stiffness);
  go(&StringParameters::friction_coefficient);
  // A tuning that comes or goes has nothing to glide from.
  if (from.frequency > 0.0 && to.frequency > 0.0) go(&StringParameters::frequency);
  return now;
}

}  // namespace hapticd
