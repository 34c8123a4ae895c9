// The way between two settings: its ends, its middle, and what switches.
#include "core/simulation/live_settings.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/contact/coupling_axes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

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

TEST_CASE("scales go by equal factors, lengths of the solver straight, and all arrive exactly") {
  const LiveSettings half = blend(old_settings(), new_settings(), 0.5);
  CHECK(half.coupling.kt == doctest::Approx(std::sqrt(1000.0 * 3000.0)));
  CHECK(half.coupling.length == doctest::Approx(std::sqrt(0.03 * 0.05)));
  CHECK(half.force_gain == doctest::Approx(std::sqrt(0.51 * 1.01) - 0.01));
  CHECK(half.scale == doctest::Approx(2.0));
  CHECK((half.X_WD.p - Vector3(2.0, 2.0, 2.0)).norm() < 1e-12);
  CHECK(std::abs(half.contact.skin - 2e-5) < 1e-18);
  const LiveSettings end = blend(old_settings(), new_settings(), 1.0);
  CHECK(end.coupling.kt == 3000.0);
  CHECK(end.force_gain == 1.0);
  CHECK(end.X_WD.q.coeffs() == new_settings().X_WD.q.coeffs());
}

TEST_CASE(
    "each axis of a coupling goes by equal factors, at the pace of the one that goes farthest") {
  LiveSettings from = old_settings();
  LiveSettings to = from;
  from.coupling = coupling_of_axes({100, 200, 400}, {1.0, 0.5, 0.1});
  to.coupling = coupling_of_axes({10000, 200, 100}, {0.1, 0.5, 4.0});
  for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const CouplingStiffness now = blend(from, to, share).coupling;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto between = [&](double a, double b) { return a * std::pow(b / a, share); };
      CHECK(now.along_W()[k] ==
            doctest::Approx(between(from.coupling.along_W()[k], to.coupling.along_W()[k])));
      CHECK(now.about_G()[k] ==
            doctest::Approx(between(from.coupling.about_G()[k], to.coupling.about_G()[k])));
    }
    CHECK(now.shares.along_W.maxCoeff() == 1.0);
  }
  CHECK(way_length(from, to).most >= std::log(100.0));
  // From one stiffness for all and back, which ends as it began.
  const LiveSettings even = old_settings();
  CHECK(blend(even, to, 0.5).coupling.per_axis);
  CHECK_FALSE(blend(to, even, 1.0).coupling.per_axis);
  CHECK(blend(even, old_settings(), 0.5).coupling.kt == even.coupling.kt);
}

TEST_CASE("orientations go the short way and stay unit") {
  const LiveSettings half = blend(old_settings(), new_settings(), 0.5);
  CHECK(half.X_WD.q.norm() == within(1.0, 1e-14));
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
  const StringParameters half = StringBlend(0.5, 1000.0)(from, to);
  CHECK(half.tension == doctest::Approx(std::sqrt(30.001 * 50.001) - 0.001));
  CHECK(half.frequency == doctest::Approx(std::sqrt(100.0 * 120.0)));
  CHECK(half.radius == 1e-3);
  CHECK(half.p_WB == to.p_WB);
  to.frequency = 0.0;
  CHECK(StringBlend(0.5, 1000.0)(from, to).frequency == 0.0);
}

TEST_CASE("an axial stiffness glides, also where it comes or goes beside Young's modulus") {
  StringParameters wound;
  wound.axial_stiffness = 2000.0;
  StringParameters stiffer = wound;
  stiffer.axial_stiffness = 8000.0;
  const auto half = [](const StringParameters& from, const StringParameters& to) {
    return axial_stiffness_of(StringBlend(0.5, 1000.0)(from, to));
  };
  CHECK(half(wound, stiffer) == within(4000.0, 1e-6));
  StringParameters solid;  // pi R^2 E of the default is 69 kN
  const double own = 1.9e11 * 3.14159265358979 * 0.34e-3 * 0.34e-3;
  CHECK(half(solid, wound) == within(std::sqrt(own * 2000.0), 1e-6));
  CHECK(half(wound, solid) == within(std::sqrt(own * 2000.0), 1e-6));
  CHECK(StringBlend(1.0, 1000.0)(wound, solid).axial_stiffness == kNoAxialStiffness);
  StringParameters slack = wound;
  slack.axial_stiffness = 0.0;
  CHECK(ramp_time(way_length(wound, slack, 1000.0)) ==
        doctest::Approx(std::log(2000.001 / 0.001) / kScalePace));
}

TEST_CASE("strings that go other ways do not take over each other's") {
  StringParameters slack;
  slack.tension = 0.0;
  StringParameters soft;
  soft.tension = 20.0;
  StringParameters tight;
  tight.tension = 80.0;
  StringBlend blend_string(0.5, 1000.0);
  for (int k = 0; k < 3; ++k) {
    CHECK(blend_string(soft, tight).tension == doctest::Approx(40.0));
    CHECK(blend_string(tight, tight).tension == 80.0);
    CHECK(blend_string(slack, soft).tension == doctest::Approx(std::sqrt(0.001 * 20.001) - 0.001));
  }
}

TEST_CASE("a contact stiffness above every coupling's takes no part of the way") {
  StringParameters from;
  from.contact_stiffness = 1e9;
  StringParameters to = from;
  to.contact_stiffness = 250.0;
  CHECK(StringBlend(1e-9, 1000.0)(from, to).contact_stiffness == doctest::Approx(1000.0));
  CHECK(StringBlend(0.5, 1000.0)(from, to).contact_stiffness == doctest::Approx(500.0));
  CHECK(ramp_time(way_length(from, to, 1000.0)) == kSettingsRamp_s);
  CHECK(ramp_time(way_length(from, to, 1e9)) == doctest::Approx(std::log(4e6) / kScalePace));
}

TEST_CASE("a way takes as long as its logarithm, and 50 ms at least") {
  LiveSettings from = old_settings();
  LiveSettings to = from;
  CHECK(ramp_time(way_length(from, to)) == kSettingsRamp_s);
  to.coupling.kt = 1500.0;
  CHECK(ramp_time(way_length(from, to)) == kSettingsRamp_s);
  from.coupling.kt = 1e9;
  to.coupling.kt = 1e-3;
  CHECK(ramp_time(way_length(from, to)) == doctest::Approx(std::log(1e12) / kScalePace));
  StringParameters tight;
  tight.tension = 1000.0;
  StringParameters slack = tight;
  slack.tension = 0.0;
  CHECK(ramp_time(way_length(tight, slack, 1000.0)) ==
        doctest::Approx(std::log(1000001.0) / kScalePace));
}

TEST_CASE("in any network of springs a change of one moves no force by more than 3/50 of its way") {
  SplitMix64 random(0x5ca1e);
  for (std::int64_t n = 0; n < scaled(20'000); ++n) {
    LiveSettings from = old_settings();
    LiveSettings to = from;
    from.coupling.kt = std::pow(10.0, random.uniform(-3.0, 9.0));
    to.coupling.kt = std::pow(10.0, random.uniform(-3.0, 9.0));
    // A force in a network is a sum of terms k / (k + c), and one that goes with k.
    std::array<double, 4> c{};
    for (double& each : c) each = std::pow(10.0, random.uniform(-4.0, 10.0));
    const double stiff = random.chance(0.5) ? 0.0 : 1e-6;
    const auto force = [&](double k) {
      double sum = stiff * k;
      for (const double each : c) sum += k / (k + each);
      return sum;
    };
    const auto ticks = static_cast<int>(std::ceil(1e3 * ramp_time(way_length(from, to))));
    double last = force(from.coupling.kt);
    double largest = 0.0;
    for (int tick = 1; tick <= ticks; ++tick) {
      const double share = std::min(1.0, 1e-3 * tick / ramp_time(way_length(from, to)));
      const double now = force(blend(from, to, share).coupling.kt);
      largest = std::max(largest, std::abs(now - last));
      last = now;
    }
    CAPTURE(from.coupling.kt);
    CAPTURE(to.coupling.kt);
    CHECK(largest <= 3.0 / 50.0 * std::abs(force(to.coupling.kt) - force(from.coupling.kt)));
  }
}

}  // namespace hapticd::test
