// Recovery from a penetrated start (a scene edited onto the tool, a start inside an obstacle): the
// way out is a translation along the normals of the deepest contacts, never faster than
// ContactOptions::recovery_speed, accepted only where it enlarges the minimum gap and closes none
// that is open. RT: yes.
#pragma once

#include <optional>

#include "core/contact/configuration.h"

namespace hapticd {

/// Where one push along `dp_W` (m) takes G, and the minimum gap there, m.
struct Push {
  Pose X_WG;
  double minimum_gap;
};

/// The push along dp_W, cut to the recovery speed and to open gaps; none when it does not enlarge
/// the minimum gap.
[[nodiscard]] HD_REALTIME std::optional<Push> push_out(const Configuration& at,
                                                       const ContactSet& contacts,
                                                       const Vector3& dp_W) noexcept;

/// Sum of the normals of the deepest contacts, scaled to the greatest depth with the `skin` (m); or
/// the deepest normal alone. There must be a contact.
[[nodiscard]] HD_REALTIME Vector3 deepest_direction(const ContactSet& contacts, bool only_deepest,
                                                    double skin) noexcept;

}  // namespace hapticd
