// The exact statics against closed forms, and from other starts.
#include "tests/truth/exact_statics.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace hapticd::test {
namespace {

constexpr double kTip = 5e-3;
constexpr double kString = 0.34e-3;
constexpr double kTop = kTip + kString;
constexpr double kPi = 3.14159265358979323846;

const std::array<Sphere, 1> kFinger = {{{{0, 0, 0}, kTip}}};
const Capsule kAlongX{{-0.55, 0, 0}, {0.55, 0, 0}, kString};

Pose at(double x, double y, double z) { return {{1, 0, 0, 0}, {x, y, z}}; }

/// The rest of a hand that comes straight down from 8 mm above.
StaticRest pressed(const StaticScene& scene, const Pose& X_WH, int steps = 20) {
  Pose above = X_WH;
  above.p.y() += 8e-3;
  StaticPlace place = free_place(scene, above);
  StaticRest rest;
  for (int k = 1; k <= steps; ++k) {
    Pose hand = X_WH;
    hand.p.y() += 8e-3 * (1.0 - static_cast<double>(k) / steps);
    rest = rest_from(scene, hand, place);
    CHECK(converged(rest));
    place = rest.place;
  }
  return rest;
}

StaticString steel(double compliance = 0.0) {
  return {kAlongX, 30.0, 1.9e11 * kPi * kString * kString, compliance};
}

}  // namespace

TEST_CASE("on a line the exact force is kt times the overlap along the line of centres") {
  const std::array<Capsule, 1> lines = {kAlongX};
  const StaticScene scene{kFinger, {}, lines, {}};
  for (const double y : {5e-3, 3e-3, 1.5e-3}) {
    for (const double z : {0.0, 1e-3, -2.5e-3}) {
      const double distance = std::hypot(y, z);
      const Vector3 truth = 1000.0 * std::max(0.0, kTop - distance) * Vector3(0, y, z) / distance;
      CHECK((pressed(scene, at(0.1, y, z)).F_H_W.f - truth).norm() < 1e-8);
    }
  }
}

TEST_CASE("between two lines the exact rest touches both") {
  for (const double half : {1e-3, 3e-3, 5e-3}) {
    const std::array<Capsule, 2> lines = {
        {{{-0.5, 0, half}, {0.5, 0, half}, kString}, {{-0.5, 0, -half}, {0.5, 0, -half}, kString}}};
    const StaticScene scene{kFinger, {}, lines, {}};
    const double height = std::sqrt(kTop * kTop - half * half);
    const StaticRest rest = pressed(scene, at(0, height - 3e-3, 1e-4));
    CHECK((rest.F_H_W.f - Vector3(0, 3.0, -0.1)).norm() < 1e-8);
  }
}

TEST_CASE("through a lever the exact force and torque balance where it touches") {
  const std::array<Sphere, 1> tool = {{{{0.06, 0, 0}, kTip}}};
  const std::array<Capsule, 1> lines = {{{{0, 0, -0.5}, {0, 0, 0.5}, kString}}};
  const StaticRest rest = pressed({tool, {}, lines, {}}, at(-0.06, kTop - 4e-3, 0));
  const Vector3 arm = rest.place.X_WG.q * tool[0].p;
  CHECK((arm.cross(rest.F_H_W.f) - rest.F_H_W.t).norm() < 1e-8);
  const Vector3 centre = rest.place.X_WG.p + arm;
  CHECK(std::hypot(centre.x(), centre.y()) == within(kTop, 1e-9));
  CHECK(rest.F_H_W.f.norm() > 0.5);
}

TEST_CASE("on a round end, a ball and a plane the exact force is kt times the overlap") {
  const std::array<Capsule, 1> lines = {{{{0, 0, 0}, {0, -0.5, 0}, 2e-3}}};
  const double slant = 3e-3;
  const double lowered = std::sqrt(49e-6 - slant * slant) - 1e-3;
  const double overlap = 7e-3 - std::hypot(slant, lowered);
  const Vector3 truth = 1000.0 * overlap * Vector3(slant, lowered, 0).normalized();
  CHECK((pressed({kFinger, {}, lines, {}}, at(slant, lowered, 0)).F_H_W.f - truth).norm() < 1e-8);
  const std::array<Sphere, 1> ball = {{{{0, -0.02, 0}, 0.02}}};
  CHECK((pressed({kFinger, ball, {}, {}}, at(0, 3e-3, 0)).F_H_W.f - Vector3(0, 2, 0)).norm() <
        1e-8);
  const std::array<Sphere, 1> plane = {{{{0, -1000, 0}, 1000}}};
  CHECK((pressed({kFinger, plane, {}, {}}, at(0.02, 4e-3, 0)).F_H_W.f.y() -
         (1.0 - 1e3 * 4e-4 / 2000)) < 1e-5);
}

TEST_CASE("in the middle of a string the exact force is that of two legs beside the vertex") {
  for (const double compliance : {0.0, 1e-3}) {
    const std::array<StaticString, 1> strings = {steel(compliance)};
    for (const double depth : {0.5e-3, 2e-3, 4e-3}) {
      // By the angle of the legs at the vertex: of the string itself, and of what stands in series.
      const auto legs = [&](double vertex) {
        double low = 0.0;
        double high = vertex;
        double force = 0.0;
        for (int i = 0; i < 200; ++i) {
          const double d = 0.5 * (low + high);
          const double leg = std::hypot(0.55, d);
          const double ext = 2 * d * d / (leg + 0.55);
          force = 2 * (30.0 + strings[0].axial * ext / 1.1) * d / leg;
          (d + compliance * force < vertex ? low : high) = d;
        }
        return force;
      };
      double low = 0.0;
      double high = depth;
      double force = 0.0;
      for (int i = 0; i < 100; ++i) {
        const double vertex = 0.5 * (low + high);
        const double angle = std::atan(vertex / 0.55);
        force = legs(vertex) / (1 - kTop * std::sin(angle) / 0.55);
        const double height = kTop / std::cos(angle) - vertex;
        (force < 1000.0 * (height - (kTop - depth)) ? low : high) = vertex;
      }
      const StaticRest rest = pressed({kFinger, {}, {}, strings}, at(0, kTop - depth, 0));
      CAPTURE(compliance);
      CAPTURE(depth);
      CHECK((rest.F_H_W.f - Vector3(0, force, 0)).norm() < 1e-6);
    }
  }
}

TEST_CASE("other ways to the same place end in the same exact rest, turned tool and all") {
  const std::array<Sphere, 3> bar = {
      {{{-0.03, 0, 0}, kTip}, {{0, 0, 0}, kTip}, {{0.03, 0, 0}, kTip}}};
  const std::array<Capsule, 1> lines = {{{{-0.027, 0, -0.3}, {-0.026, 0, 0.3}, 1e-3}}};
  const std::array<StaticString, 1> strings = {
      {{{{0.03, 0, -0.5}, {0.032, 0, 0.6}, kString}, 40.0, 7e4, 0.0}}};
  const StaticScene scene{bar, {}, lines, strings};
  Pose hand = at(0.001, kTop - 2e-3, 1e-3);
  hand.q = Quaternion(Eigen::AngleAxisd(0.05, Vector3(1, 2, 3).normalized()));
  const StaticRest rest = pressed(scene, hand, 20);
  for (const int steps : {12, 37}) {
    const StaticRest other = pressed(scene, hand, steps);
    CHECK((other.F_H_W.f - rest.F_H_W.f).norm() < 1e-7);
    CHECK((other.F_H_W.t - rest.F_H_W.t).norm() < 1e-9);
  }
  CHECK(rest.F_H_W.f.norm() > 0.3);
}

TEST_CASE("a finger that is led past the axis of a line ends on its other side") {
  const std::array<Capsule, 1> lines = {kAlongX};
  const StaticScene scene{kFinger, {}, lines, {}};
  StaticPlace place = free_place(scene, at(0, 8e-3, 1e-4));
  StaticRest rest;
  for (int k = 0; k <= 160; ++k) {
    rest = rest_from(scene, at(0, 8e-3 - 1e-4 * k, 1e-4), place);
    CHECK(converged(rest));
    place = rest.place;
  }
  CHECK(rest.F_H_W.f.norm() == doctest::Approx(0.0).epsilon(1e-9));
  CHECK(place.X_WG.p.y() == doctest::Approx(-8e-3));
}

TEST_CASE("20 um of skin are 20 mN of exact force: the control") {
  const std::array<Capsule, 1> lines = {kAlongX};
  StaticScene scene{kFinger, {}, lines, {}};
  const Vector3 exact = pressed(scene, at(0, 3e-3, 0)).F_H_W.f;
  scene.fattening = 20e-6;
  CHECK((pressed(scene, at(0, 3e-3, 0)).F_H_W.f - exact).norm() == doctest::Approx(0.020));
}

}  // namespace hapticd::test
