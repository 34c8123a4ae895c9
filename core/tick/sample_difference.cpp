// See sample_difference.h.
#include "core/tick/sample_difference.h"

#include <cmath>

#include "core/math/pose.h"
#include "core/math/rotation.h"

namespace hapticd {
namespace {

bool finite(const Vector3& v) noexcept {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

}  // namespace

void difference_velocity(const DeviceSample& last, DeviceSample& sample) noexcept {
  sample.v_DH_D = sample.w_DH_D = {};
  if (sample.t_ns <= last.t_ns) return;
  const double dt = static_cast<double>(sample.t_ns - last.t_ns) * 1e-9;
  const Vector3 v = (to_vector(sample.p_DH) - to_vector(last.p_DH)) / dt;
  const Quaternion turn =
      renormalised(to_quaternion(sample.q_DH)) * renormalised(to_quaternion(last.q_DH)).conjugate();
  const Vector3 w = log_rotation(turn) / dt;
  if (!finite(v) || !finite(w)) return;
  sample.v_DH_D = to_array(v);
  sample.w_DH_D = to_array(w);
}

}  // namespace hapticd
