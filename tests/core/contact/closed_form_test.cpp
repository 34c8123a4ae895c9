// Forces of a single sphere against closed forms: press with offset, lever, wedge of two strings,
// flat plate of spheres. Truth: the energy minimum on the exact obstacle.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kTip = 5e-3;
constexpr double kString = 0.34e-3;
constexpr double kForceTolerance = 5e-3;
constexpr int kTicks = 20;

Capsule string_along_x(double y, double z) { return {{-0.55, y, z}, {0.55, y, z}, kString}; }

/// Distance of the two centres at contact.
constexpr double contact_distance() { return kTip + kString; }

}  // namespace

TEST_CASE(
    "a fingertip pressed on a string with an offset feels kt times the overlap along the line of "
    "centres") {
  RenderingScene scene({{{0, 0, 0}, kTip}});
  scene.capsules_W = {string_along_x(0, 0)};
  const double s = contact_distance();
  for (const double depth : {0.1e-3, 0.5e-3, 1e-3, 2e-3, 4e-3}) {
    for (const double offset : {0.0, 0.3e-3, -1e-3, 2.5e-3}) {
      CAPTURE(depth);
      CAPTURE(offset);
      ToolRun run(scene, pose_at({0.1, 0.02, offset}));
      const Vector3 p_WH(0.1, s - depth, offset);
      run.hold(pose_at(p_WH), kTicks);
      const double distance = std::hypot(p_WH.y(), p_WH.z());
      const double overlap = std::max(0.0, s - distance);
      const Vector3 truth = run.stiffness.kt * overlap * Vector3(0, p_WH.y(), p_WH.z()) / distance;
      CHECK((run.result.F_H_W.f - truth).norm() < kForceTolerance);
      CHECK(run.result.F_H_W.t.norm() < kForceTolerance * kTip);
    }
  }
}

TEST_CASE("a fingertip wedged between two strings is held at the height where both touch") {
  RenderingScene scene({{{0, 0, 0}, kTip}});
  const double s = contact_distance();
  for (const double half_spacing : {1e-3, 3e-3, 4.5e-3, 5.2e-3}) {
    CAPTURE(half_spacing);
    scene.capsules_W = {string_along_x(0, half_spacing), string_along_x(0, -half_spacing)};
    ToolRun run(scene, pose_at({0, 0.02, 0.2e-3}));
    const double height = std::sqrt(s * s - half_spacing * half_spacing);
    const Vector3 p_WH(0, height - 3e-3, 0.1e-3);
    run.hold(pose_at(p_WH), kTicks);
    const Vector3 truth = run.stiffness.kt * (Vector3(0, height, 0) - p_WH);
    CHECK((run.result.F_H_W.f - truth).norm() < kForceTolerance);
    CHECK(run.result.active_count == 2);
  }
}

TEST_CASE(
    "a fingertip pressed through a lever finds the energy minimum over position and rotation") {
  const double lever = 0.06;
  RenderingScene scene({{{lever, 0, 0}, kTip}});
  scene.capsules_W = {{{0, 0, -0.5}, {0, 0, 0.5}, kString}};
  const double s = contact_distance();
  for (const double depth : {0.5e-3, 2e-3, 4e-3}) {
    CAPTURE(depth);
    ToolRun run(scene, pose_at({-lever, 0.02, 0}));
    const Vector3 p_WH(-lever, s - depth, 0);
    run.hold(pose_at(p_WH), kTicks);

    // Contact at angle beta on the circle of radius s, tool turned by phi: both stationarity
    // conditions by Newton, long double.
    const long double kt = static_cast<long double>(run.stiffness.kt);
    const long double kr = static_cast<long double>(run.stiffness.kr());
    const auto energy = [&](long double beta, long double phi) {
      const long double x = s * std::cos(beta) - lever * std::cos(phi) - p_WH.x();
      const long double y = s * std::sin(beta) - lever * std::sin(phi) - p_WH.y();
      return 0.5L * (kt * (x * x + y * y) + kr * phi * phi);
    };
    long double beta = 1.5707963267948966L;
    long double phi = 0.0L;
    const long double h = 1e-5L;
    for (int i = 0; i < 50; ++i) {
      const long double gb = (energy(beta + h, phi) - energy(beta - h, phi)) / (2 * h);
      const long double gp = (energy(beta, phi + h) - energy(beta, phi - h)) / (2 * h);
      const long double bb =
          (energy(beta + h, phi) - 2 * energy(beta, phi) + energy(beta - h, phi)) / (h * h);
      const long double pp =
          (energy(beta, phi + h) - 2 * energy(beta, phi) + energy(beta, phi - h)) / (h * h);
      const long double bp = (energy(beta + h, phi + h) - energy(beta + h, phi - h) -
                              energy(beta - h, phi + h) + energy(beta - h, phi - h)) /
                             (4 * h * h);
      const long double det = bb * pp - bp * bp;
      beta -= (gb * pp - gp * bp) / det;
      phi -= (gp * bb - gb * bp) / det;
    }
    const Vector3 p_WG(static_cast<double>(s * std::cos(beta) - lever * std::cos(phi)),
                       static_cast<double>(s * std::sin(beta) - lever * std::sin(phi)), 0);
    const Vector3 truth_f = run.stiffness.kt * (p_WG - p_WH);
    CHECK((run.result.F_H_W.f - truth_f).norm() < kForceTolerance);
    CHECK(std::abs(run.result.F_H_W.t.z() - static_cast<double>(kr * phi)) <
          kForceTolerance * lever);
  }
}

TEST_CASE("pressed on a flat plate the force is kt times the depth, whatever the stiffness") {
  RenderingScene scene({{{0, 0, 0}, kTip}});
  scene.add_body({{{0, -1000, 0}, 1000}}, pose_at({0, 0, 0}));
  for (const double kt : {1e-3, 1.0, 1e3, 1e6, 1e9}) {
    CAPTURE(kt);
    ToolRun run(scene, pose_at({0, 0.01, 0}));
    run.stiffness.kt = kt;
    run.hold(pose_at({0, kTip - 2e-3, 0}), kTicks);
    CHECK(run.result.F_H_W.f.y() / kt == within(2e-3, 1e-6));
  }
}

}  // namespace hapticd::test
