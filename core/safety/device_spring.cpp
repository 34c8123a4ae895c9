// See device_spring.h. RT: yes.
#include "core/safety/device_spring.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/// No coupling is stiffer, N/m and N m/rad: it only keeps products finite.
constexpr double kStiffest = 1e9;

/// Added to the diagonal, relative to the largest entry, before K is judged: what rounding makes of
/// a spring along one direction is not refused. Smaller: the third minor of such a spring, its
/// square, drowns in rounding; larger: a spring may push along a way by that share.
constexpr double kSemidefinite = 1e-6;

/// K gives nothing along any way: with kSemidefinite added all leading minors are above zero. The
/// other ones need not be looked at then (Sylvester). Entries finite, relative to the largest one.
bool gives_nothing(const std::array<double, 6>& K) noexcept {
  double largest = 0.0;
  for (const double entry : K) largest = std::max(largest, std::abs(entry));
  if (!(largest > 0.0)) return true;
  const double xx = K[0] / largest + kSemidefinite;
  const double yy = K[1] / largest + kSemidefinite;
  const double zz = K[2] / largest + kSemidefinite;
  const double xy = K[3] / largest;
  const double xz = K[4] / largest;
  const double yz = K[5] / largest;
  const double minor = xx * yy - xy * xy;
  const double all = zz * minor - xx * yz * yz + xz * (2.0 * xy * yz - yy * xz);
  return xx > 0.0 && minor > 0.0 && all > 0.0;
}

bool sound(const DeviceSpring& spring) noexcept {
  bool good = true;
  for (std::size_t i = 0; i < 3; ++i) {
    good = good && spring.K_D[i] >= 0.0 && spring.K_D[i] <= kStiffest;
    good = good && std::abs(spring.K_D[i + 3]) <= kStiffest;
    good = good && spring.Kr_D[i] >= 0.0 && spring.Kr_D[i] <= kStiffest;
  }
  return good && gives_nothing(spring.K_D);
}

/// Largest share, up to 1, of a spring of `stiffness` that the hand at `speed` does not stretch by
/// more than `room` (N or N m) within the horizon.
double share_of(double stiffness, double speed, double horizon_s, double room) noexcept {
  const double change = stiffness * speed * horizon_s;
  if (!(room > 0.0)) return 0.0;
  return change > room ? room / change : 1.0;
}

}  // namespace

double row_bound(const std::array<double, 6>& K) noexcept {
  const auto [xx, yy, zz, xy, xz, yz] = K;
  return std::max({std::abs(xx) + std::abs(xy) + std::abs(xz),
                   std::abs(xy) + std::abs(yy) + std::abs(yz),
                   std::abs(xz) + std::abs(yz) + std::abs(zz)});
}

DeviceSpring grant_spring(const DeviceSpring& wanted, const SpringContext& context) noexcept {
  DeviceSpring granted;
  const SafetyOutput& written = context.written;
  const double speed = context.V_DH_D.v.norm();
  const double turning = context.V_DH_D.w.norm();
  const bool allowed = written.enable && written.flags == 0 && context.gain >= 1.0 &&
                       context.stiffness_max >= 0.0 && std::isfinite(speed) &&
                       std::isfinite(turning) && context.horizon_s >= 0.0 &&
                       std::isfinite(context.horizon_s);
  if (!allowed || !sound(wanted)) return granted;
  const double force = to_vector(written.f_H_D).norm();
  const double torque = to_vector(written.t_H_D).norm();
  const double stiffness = row_bound(wanted.K_D);
  const double rotational = *std::max_element(wanted.Kr_D.begin(), wanted.Kr_D.end());
  const double room = std::min({force, context.peak.force - force, kForceSlew * context.horizon_s});
  const double torque_room =
      std::min({torque, context.peak.torque - torque, kTorqueSlew * context.horizon_s});
  double share = share_of(stiffness, speed, context.horizon_s, room);
  if (stiffness > context.stiffness_max) {
    share = std::min(share, context.stiffness_max / stiffness);
  }
  const double torque_share = share_of(rotational, turning, context.horizon_s, torque_room);
  for (std::size_t i = 0; i < 6; ++i) granted.K_D[i] = share * wanted.K_D[i];
  for (std::size_t i = 0; i < 3; ++i) granted.Kr_D[i] = torque_share * wanted.Kr_D[i];
  return granted;
}

}  // namespace hapticd
