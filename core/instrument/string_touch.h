// What the contact stage gives a string about one tick, and the time of that tick. RT: plain data.
#pragma once

#include <cstdint>
#include <optional>

namespace hapticd {

/// The tick that ends at t_ns and lasted dt_ns >= 0 (0: no new sample; nothing moves).
struct TickTime {
  std::int64_t t_ns = 0;
  std::int64_t dt_ns = 0;
};

/// Signed distances are positive outside. One per string and tick, for the tool nearest to it.
struct StringTouch {
  TickTime time;
  /// Distance of the tool's surface to the resting string's surface at the start and end of the
  /// tick, m: the gap where there is no contact, and minus the displacement D of the hand into the
  /// string (deflection plus what the coupling yields, force / kc) where there is. Their zero
  /// crossing is the instant of a touch or a loss.
  double distance_before = 1.0;
  double distance = 1.0;
  /// Share of the tick, in [0, 1], at which the hand passes the surface, where the caller knows it
  /// better than the straight line between the distances tells; negative: it does not, or the hand
  /// does not pass.
  double passing = -1.0;
  double force = 0.0;         ///< F_r: static contact force of the string on the tool, N, >= 0
  double deflection = 0.0;    ///< delta of the string at lambda, m, >= 0
  double lambda = 0.5;        ///< place of the touch, or of the nearest point, in [0, 1]
  double stiffness = 1000.0;  ///< of what presses: the tool's coupling in series with kc, N/m, > 0
  /// Tool against string at the contact, along the direction into the string (positive = hitting)
  /// and across it (>= 0), m/s. Sent with events; with the motion of the distance it bounds what a
  /// held force can do.
  double normal_speed = 0.0;
  double tangential_speed = 0.0;
  /// Way of the hand over the tick along the normal at its start, away from the string, m: what a
  /// force held meanwhile does work on. None: the change of the distance, as of a hand that goes
  /// straight.
  std::optional<double> way;
  /// Speed of the hand along the normal at the end of the tick, either sign, m/s.
  double hand_speed = 0.0;
};

}  // namespace hapticd
