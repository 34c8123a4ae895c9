// The way between two settings: its ends, its middle, and what switches.
#include "core/simulation/live_settings.h"

#include <doctest/doctest.h>

#include <cmath>

namespace hapticd::test {
namespace {

LiveSettings old_settings() {
  LiveSettings settings;
  settings.coupling = {1000.0, 0.03};
  settings.force_gain = 0.5;
  settings.scale = 1.0;
  settings.X_WD.p = Vector3(1.0, 2.0, 3.0);
  settings.contact.sub_steps = 8;
  settings.contact.skin = 1e-5;
  return settings;
}

/// Turned by 90 degrees about z, by the quaternion that is far away.
LiveSettings new_settings() {
  LiveSettings settings = old_settings();
  settings.coupling = {3000.0, 0.05};
  settings.force_gain = 1.0;
  settings.scale = 4.0;
  settings.X_WD.p = Vector3(3.0, 2.0, 1.0);
  settings.X_WD.q = {-std::sqrt(0.5), 0.0, 0.0, -std::sqrt(0.5)};
  settings.contact.sub_steps = 24;
  settings.contact.skin = 3e-5;
  return settings;
}

}  // namespace

TEST_CASE("numbers go straight from old to new and arrive exactly") {
  const LiveSettings half = blend(old_settings(), new_settings(), 0.5);
  CHECK(half.coupling.kt == doctest::Approx(2000.0));
  CHECK(half.coupling.length == doctest::Approx(0.04));
  CHECK(half.force_gain == doctest::Approx(0.75));
  CHECK(half.scale == doctest::Approx(2.5));
  CHECK((half.X_WD.p - Vector3(2.0, 2.0, 2.0)).norm() < 1e-12);
  CHECK(std::abs(half.contact.skin - 2e-5) < 1e-18);
  const LiveSettings end = blend(old_settings(), new_settings(), 1.0);
  CHECK(end.coupling.kt == 3000.0);
  CHECK(end.X_WD.q.coeffs() == new_settings().X_WD.q.coeffs());
}

TEST_CASE("orientations go the short way and stay unit") {
  const LiveSettings half = blend(old_settings(), new_settings(), 0.5);
  CHECK(half.X_WD.q.norm() == doctest::Approx(1.0).epsilon(1e-14));
  // 45 degrees about z, either sign of the quaternion.
  const double angle = 2.0 * std::atan2(std::abs(half.X_WD.q.z()), std::abs(half.X_WD.q.w()));
  CHECK(angle == doctest::Approx(3.14159265358979 / 4.0));
  CHECK(half.X_WD.q.z() * half.X_WD.q.w() > 0.0);
}

TEST_CASE("counts and choices are the new ones at once") {
  CHECK(blend(old_settings(), new_settings(), 0.01).contact.sub_steps == 24);
}

TEST_CASE("a string's tension glides, its ends and radius do not") {
  StringParameters from;
  from.tension = 30.0;
  from.frequency = 100.0;
  StringParameters to = from;
  to.tension = 50.0;
  to.radius = 1e-3;
  to.p_WB = {1.0, 0.0, 0.0};
  to.frequency = 120.0;
  const StringParameters half = blend(from, to, 0.5);
  CHECK(half.tension == doctest::Approx(40.0));
  CHECK(half.frequency == doctest::Approx(110.0));
  CHECK(half.radius == 1e-3);
  CHECK(half.p_WB == to.p_WB);
  to.frequency = 0.0;
  CHECK(blend(from, to, 0.5).frequency == 0.0);
}

}  // namespace hapticd::test
