// See contact_sessions.h.
#include "tests/support/contact_sessions.h"

#include <algorithm>
#include <cmath>

namespace hapticd::test {
namespace {

constexpr double kLineRadius = 3e-3;

/// 120 spheres on an ellipsoid of 60 x 40 x 50 mm.
std::vector<Sphere> ellipsoid() {
  constexpr int kCount = 120;
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<Sphere> spheres;
  for (int i = 0; i < kCount; ++i) {
    const double y = 1.0 - 2.0 * (i + 0.5) / kCount;
    const double ring = std::sqrt(1.0 - y * y);
    const double angle = kGoldenAngle * i;
    spheres.push_back(
        {{0.030 * ring * std::cos(angle), 0.020 * y, 0.025 * ring * std::sin(angle)}, 5e-3});
  }
  return spheres;
}

/// A column of spheres, 100 mm high and 16 mm thick.
SessionBody pillar(const Vector3& p_WB) {
  constexpr double kRadius = 8e-3;
  SessionBody body{{}, p_WB};
  for (int i = 0; i <= 50; ++i) body.spheres_B.push_back({{0.0, 2e-3 * i, 0.0}, kRadius});
  return body;
}

Capsule line(double z) { return {{-0.3, 0.0, z}, {0.3, 0.0, z}, kLineRadius}; }

/// Smooth step from 0 to 1 between t0 and t1.
double ramp(double t, double t0, double t1) {
  const double s = std::clamp((t - t0) / (t1 - t0), 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

/// The turning and tilting that the presses share.
Vector3 turning(double t) { return {0.1 * std::sin(5 * t), 0.2 * t, 0.1 * std::sin(4 * t)}; }

}  // namespace

ContactSession single_press() {
  return {"single press", ellipsoid(), {line(0.0)}, {}, 1.0, [](double t) -> SessionPose {
            return {{0.002 * std::sin(9 * t), 0.040 - 0.018 * ramp(t, 0.0, 0.3),
                     0.003 * std::sin(7 * t)},
                    turning(t)};
          }};
}

ContactSession two_lines() {
  return {
      "two lines", ellipsoid(), {line(0.015), line(-0.015)}, {}, 1.0, [](double t) -> SessionPose {
        return {
            {0.002 * std::sin(9 * t), 0.040 - 0.020 * ramp(t, 0.0, 0.3), 0.002 * std::sin(7 * t)},
            turning(t)};
      }};
}

ContactSession line_and_pillar() {
  return {"line and pillar",
          ellipsoid(),
          {line(0.0)},
          {pillar({0.0, -0.02, 0.040})},
          1.0,
          [](double t) -> SessionPose {
            return {{0.002 * std::sin(9 * t), 0.045 - 0.020 * ramp(t, 0.0, 0.3),
                     0.006 * ramp(t, 0.2, 0.5)},
                    turning(t)};
          }};
}

ContactSession contact_switch() {
  return {"contact switch",
          ellipsoid(),
          {line(0.0)},
          {pillar({0.06, -0.09, 0.0})},
          2.0,
          [](double t) -> SessionPose {
            return {{0.06 - 0.10 * ramp(t, 0.2, 1.0) + 0.10 * ramp(t, 1.1, 1.9),
                     0.045 - 0.014 * ramp(t, 0.0, 0.2), 0.001},
                    {0.0, 0.1 * std::sin(3 * t), 0.1 * std::sin(4 * t)}};
          }};
}

ContactSession twisted_wedge() {
  return {"wedge with slips",
          ellipsoid(),
          {line(0.022), line(-0.022)},
          {},
          1.0,
          [](double t) -> SessionPose {
            return {{0.0, 0.040 - 0.030 * ramp(t, 0.0, 0.4), 0.001 * std::sin(7 * t)},
                    {0.05 * std::sin(5 * t), 0.3 * ramp(t, 0.4, 0.8), 0.05 * std::sin(4 * t)}};
          }};
}

std::vector<ContactSession> contact_sessions() {
  return {single_press(), two_lines(), line_and_pillar(), contact_switch(), twisted_wedge()};
}

}  // namespace hapticd::test
