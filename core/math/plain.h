// Plain twins of pose, twist and wrench, for everything that crosses a thread or a file: copies of
// doubles, no arithmetic (Eigen types are not trivially copyable). RT: yes.
#pragma once

#include "core/math/pose.h"
#include "core/math/wrench.h"

namespace hapticd {

/// Plain twin of Pose.
struct PlainPose {
  Array3 p{};                    ///< m
  Array4 q{1.0, 0.0, 0.0, 0.0};  ///< (w, x, y, z)
};

/// Plain twin of Twist.
struct PlainTwist {
  Array3 v{};  ///< m/s
  Array3 w{};  ///< rad/s
};

/// Plain twin of Wrench.
struct PlainWrench {
  Array3 f{};  ///< N
  Array3 t{};  ///< N m
};

[[nodiscard]] inline PlainPose to_plain(const Pose& X) noexcept {
  return {to_array(X.p), to_array(X.q)};
}
[[nodiscard]] inline PlainTwist to_plain(const Twist& V) noexcept {
  return {to_array(V.v), to_array(V.w)};
}
[[nodiscard]] inline PlainWrench to_plain(const Wrench& F) noexcept {
  return {to_array(F.f), to_array(F.t)};
}

}  // namespace hapticd
