// The 3-vectors and quaternions of core, and their plain twins for everything that crosses a thread
// or a file (Eigen types are not trivially copyable). Quaternions are Hamilton, stored and passed
// (w, x, y, z). RT: yes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace hapticd {

/// Coordinates of a point, direction or rotation vector, (x, y, z).
using Vector3 = Eigen::Vector3d;
/// Rotation or other linear map of 3-vectors.
using Matrix3 = Eigen::Matrix3d;
/// Orientation; of unit norm where it is one.
using Quaternion = Eigen::Quaterniond;

/// Plain storage of a 3-vector, (x, y, z).
using Array3 = std::array<double, 3>;
/// Plain storage of a quaternion, (w, x, y, z).
using Array4 = std::array<double, 4>;

/// The vector of a plain array; no component changes.
[[nodiscard]] inline Vector3 to_vector(const Array3& a) noexcept { return {a[0], a[1], a[2]}; }
/// The plain array of a vector.
[[nodiscard]] inline Array3 to_array(const Vector3& v) noexcept { return {v.x(), v.y(), v.z()}; }
/// The quaternion of a plain array (w, x, y, z); not normalised.
[[nodiscard]] inline Quaternion to_quaternion(const Array4& a) noexcept {
  return {a[0], a[1], a[2], a[3]};
}
/// The plain array (w, x, y, z) of a quaternion.
[[nodiscard]] inline Array4 to_array(const Quaternion& q) noexcept {
  return {q.w(), q.x(), q.y(), q.z()};
}

}  // namespace hapticd
