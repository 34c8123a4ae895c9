// Passivity observer and controller over the 6-DoF port of the handle (Hannaford and Ryu 2002,
// "Time-domain passivity control of haptic interfaces"). The observer adds up the wrench actually
// written over the measured displacement, which is exact for a held wrench: E = sum F_prev . dx is
// the net energy given to the hand; negative: the hand has put in more. Frames: F_H_D, V_DH_D.
//
// The bound: E - (damping of the device that repaid debt) <= allowance + largest budget so far, for
// every motion within the accelerations below while no tick outlasts hold_s. Three steps:
//  - smooth, well before: the wrench fades while it adds to a debt, by less than 5 % in 10 ms
//  - soft, below half of the allowance: takes a growing share out of the part of the wrench along
//    the motion (energy_debt.h), and from soft_share on just as much as the next tick would give
//    too much; what presses across the motion stays
//  - hard: shortens the whole wrench so that the worst motion of the next tick cannot pass the
//  bound
// Deviation: the publication adds a damping force that may exceed what is taken; here the wrench is
// only ever reduced, never turned round, since the device's own damping repays the rest and a
// turned force would buzz at low speed. A pluck gives back less than was put in, so no step
// touches it; what does is a spring too stiff for its delay.
// Where a wrench may come late all of this is done for each delay up to that, and the worst holds.
// RT: yes, about 20 ns; with 3 ticks of delay four times that.
#pragma once

#include <array>

#include "core/math/realtime.h"
#include "core/math/vector.h"
#include "core/math/wrench.h"

namespace hapticd {

/// Debt that is forgiven, W: 0.6 mJ in a minute. Without it a device of which no damping is known
/// would have to be restarted once all of the allowance is gone. Larger: a hand that goes to and
/// fro for long is given more than the allowance; smaller: the force stays away for longer.
inline constexpr double kForgivenPower = 1e-5;

/// Most ticks by which a wrench may reach the hand late and still be counted. Larger: what is on
/// its way takes its share of the allowance, so a stiff spring is felt softer; smaller: a device
/// that is later gives energy that nobody counts.
inline constexpr int kMostFlight = 3;

/// Knobs. All finite, >= 0.
struct PassivityLimits {
  /// Energy that may be given beyond what was put in and the budgets, J. A spring k tapped with the
  /// speed v needs k ((v + acceleration T) T)^2 / 2 of it: 1.1 mJ at 1 kN/m and 1 m/s. Larger: a
  /// handle of 0.15 kg left alone reaches sqrt(2 E/m) = 0.23 m/s at 4 mJ; smaller: fast taps lose
  /// their first newton.
  double allowance = 4e-3;
  /// Share of the allowance from which on the soft step takes out all that is too much, [0, 1].
  /// Smaller: what owes is cut before it had the time to fade.
  double soft_share = 0.9;
  /// Largest credit that is remembered, J: what the springs of the scene can store and give back.
  /// Larger: a session of plucking pays for a long buzz; smaller: a spring pressed deep is not paid
  /// back. 22 N on 500 N/m hold 0.48 J.
  double credit = 0.5;
  /// What no held handle exceeds, m/s^2 and rad/s^2; profile data and the same over 0.1 m.
  double acceleration = 500.0;
  double angular_acceleration = 5000.0;
  /// Damping b of the device, N s/m and N m s/rad: repays debt while the handle moves. With 0 debt
  /// is only repaid by work of the hand, and with all of the allowance gone there is no force to
  /// work against: then time alone ends it (kForgivenPower).
  double damping = 1.0;
  double rotational_damping = 1e-3;
};

/// Wrenches that may be on their way to the hand, newest first, and what would have been given were
/// they 1, 2 or 3 ticks late, J, as PortEnergy::given.
struct WrenchFlight {
  std::array<Array3, kMostFlight> f_H_D{};
  std::array<Array3, kMostFlight> t_H_D{};
  std::array<double, kMostFlight> given{};
};

/// Kept between ticks.
struct PortEnergy {
  double given = 0.0;    ///< net energy given to the hand, J, within [-credit, allowance + budget]
  double removed = 0.0;  ///< kept back by the controller since the start, J (as predicted)
  double share = 1.0;    ///< of the wrench that the slow factor leaves, (0, 1]
  WrenchFlight flight;   ///< not kept while no wrench is late
};

/// Observer and controller of a port in one tick.
class PassivityControl {
 public:
  /// `budget` (J, >= 0) may be given beyond the allowance. Wrenches reach the hand up to `flight`
  /// ticks late, 0 to kMostFlight: for each delay up to that the energy is counted, and the worst
  /// of them counts. Limits and port must outlive this.
  PassivityControl(const PassivityLimits& limits, double budget, PortEnergy& port,
                   int flight = 0) noexcept
      : limits_(limits), budget_(budget), port_(port), flight_(flight) {}

  /// The observer: `F_prev` was held while the handle moved by `displacement` (m, rad) in `dt_s`.
  HD_REALTIME void observe(const Wrench& F_prev, const Twist& displacement, double dt_s) noexcept;

  /// The port is without force: what is owed stays owed, what the hand has put in is forgotten.
  HD_REALTIME void rest() noexcept;

  /// The smooth step: `F` faded as far as what is owed asks for.
  [[nodiscard]] HD_REALTIME Wrench faded(const Wrench& F, const Twist& V, double hold_s) noexcept;

  /// The soft step: `F` less what it would give too much along `V` in the next `hold_s`.
  [[nodiscard]] HD_REALTIME Wrench damped(const Wrench& F, const Twist& V, double hold_s) noexcept;

  /// The hard step: factor in [0, 1] on `F` that keeps the bound whatever the hand does next.
  [[nodiscard]] HD_REALTIME double energy_share(const Wrench& F, const Twist& V,
                                                double hold_s) const noexcept;

 private:
  /// `given` after `F` was held over `displacement`.
  [[nodiscard]] double counted(double given, const Wrench& F, const Twist& displacement,
                               double dt_s) const noexcept;
  /// Most that `F` can give in a tick that begins after `ticks` others, J, from the speed `V` now.
  [[nodiscard]] double worst(const Wrench& F, const Twist& V, double hold_s,
                             int ticks) const noexcept;
  /// Most that what is on its way can give before a wrench that comes `delay` ticks late, J.
  [[nodiscard]] double under_way(const Twist& V, double hold_s, int delay) const noexcept;
  /// What was given under the worst of the delays, J.
  [[nodiscard]] double owed() const noexcept;

  const PassivityLimits& limits_;
  double budget_;
  PortEnergy& port_;
  int flight_;
};

}  // namespace hapticd
