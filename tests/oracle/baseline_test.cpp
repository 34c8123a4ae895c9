// The methods ours is compared with, against closed forms on a single sphere and a single string;
// pop-through by its definition; what they get wrong is seen.
#include "tests/oracle/baseline.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "core/scene/scene.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/oracle/pop_through.h"
#include "tests/oracle/pose_stream.h"
#include "tests/server/model/temporary_folder.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kFinger = 5e-3;
constexpr double kRadius = 0.34e-3;
constexpr double kReach = kFinger + kRadius;
constexpr double kLength = 1.1;

/// A finger of one sphere over a string along x, from -0.55 to 0.55 m.
SceneDescription finger_and_string() {
  SceneDescription scene = finger_scene({0.0, 0.05, 0.0});
  scene.strings.push_back(string_between({-0.55, 0.0, 0.0}, {0.55, 0.0, 0.0}));
  StringParameters& string = scene.strings[0].parameters;
  string.radius = kRadius;
  string.frequency = 100.0;
  string.model = StringContact::kStraight;
  return scene;
}

Pose at(double x, double y, double z = 0.0) { return {{1.0, 0.0, 0.0, 0.0}, {x, y, z}}; }

/// Eq. 10-12 as printed, for the middle of the string, in long double.
double printed(double delta) {
  const long double half = 0.55L;
  const long double d = delta;
  const long double side = std::sqrt(half * half + d * d);
  const long double area = std::numbers::pi_v<long double> * 0.34e-3L * 0.34e-3L;
  const long double axial = 1.9e11L * area * (2 * side - 1.1L) / 1.1L;
  return static_cast<double>((30 + axial) * 2 * std::sin(d / side));
}

/// Presses from above, `step` a tick, down to `depth` below the first touch.
BaselineTick press(Baseline& baseline, const ToolScene& scene, double depth, double step = 1e-5) {
  BaselineTick tick;
  for (double d = -1e-3; d < depth; d += step) {
    tick = baseline.tick(scene, at(0.0, kReach - d), 1e-3);
  }
  return baseline.tick(scene, at(0.0, kReach - depth), 1e-3);
}

}  // namespace

TEST_CASE("the paper's press in the middle of a string gives its printed force, at the surface") {
  const Scene scene(finger_and_string());
  const ToolScene tool = scene.tool_scene(0);
  for (const double depth : {1e-4, 1e-3, 3e-3}) {
    Baseline baseline(tool, {});
    const BaselineTick tick = press(baseline, tool, depth);
    CHECK(tick.X_WG.p.y() == within(kReach, 1e-6));
    CHECK(tick.deflection == within(depth, 1e-5));
    CHECK(tick.F_H_W.f.y() == within(printed(depth), 1e-4));
    CHECK(std::abs(tick.F_H_W.f.x()) < 1e-12);
  }
}

TEST_CASE("pressed deeper than the finger is thick, the paper's tool has popped through") {
  const Scene scene(finger_and_string());
  const ToolScene tool = scene.tool_scene(0);
  Baseline baseline(tool, {});
  PopThroughWatch watch(tool);
  Pose X_WG = at(0.0, 0.02);
  int popped = 0;
  for (double y = 0.02; y > -0.02; y -= 1e-4) {
    const BaselineTick tick = baseline.tick(tool, at(0.0, y), 1e-3);
    popped += watch.go(X_WG, tick.X_WG)[0] ? 1 : 0;
    X_WG = tick.X_WG;
  }
  CHECK(popped == 1);
  CHECK(X_WG.p.y() < -0.015);
}

TEST_CASE("a penalty is kt times the depth, and lets go beyond the axis") {
  const Scene scene(finger_and_string());
  const ToolScene tool = scene.tool_scene(0);
  BaselineOptions options;
  options.method = BaselineMethod::kPenalty;
  Baseline baseline(tool, options);
  CHECK(baseline.tick(tool, at(0.0, kReach - 2e-3), 1e-3).F_H_W.f.y() ==
        within(2e-3 * tool.stiffness.kt, 1e-9));
  CHECK(baseline.tick(tool, at(0.0, -kReach + 2e-3), 1e-3).F_H_W.f.y() ==
        within(-2e-3 * tool.stiffness.kt, 1e-9));
  CHECK(baseline.tick(tool, at(0.0, kReach + 1e-9), 1e-3).F_H_W.f.norm() == 0.0);
  // Round ends: 1 mm into the cap.
  CHECK(baseline.tick(tool, at(0.55 + kReach - 1e-3, 0.0), 1e-3).F_H_W.f.x() ==
        within(1e-3 * tool.stiffness.kt, 1e-9));
}

TEST_CASE("the collision radius follows what rings, or nothing, as asked") {
  const Scene scene(finger_and_string());
  const ToolScene tool = scene.tool_scene(0);
  for (const Breathing breathing : {Breathing::kNone, Breathing::kReleased}) {
    BaselineOptions options;
    options.breathing = breathing;
    Baseline baseline(tool, options);
    (void)press(baseline, tool, 2e-3);
    (void)baseline.tick(tool, at(0.0, 0.05), 1e-3);
    const BaselineTick later = baseline.tick(tool, at(0.0, 0.05), 1e-3);
    const double rings = breathing == Breathing::kNone ? 0.0 : 2e-3;
    CHECK(later.radius_growth == within(rings, 1e-4));
    // A millimetre above the resting string is inside the ringing one.
    const BaselineTick above = baseline.tick(tool, at(0.0, kReach + 1e-3), 1e-3);
    CHECK(above.pairs == (breathing == Breathing::kNone ? 0 : 1));
  }
}

TEST_CASE("the paper's string ends at a cliff a margin beyond its end") {
  const Scene scene(finger_and_string());
  const ToolScene tool = scene.tool_scene(0);
  BaselineOptions options;
  options.lambda_margin = 0.01;
  const double edge = 0.55 + 0.01 * kLength;
  Baseline inside(tool, options);
  CHECK(inside.tick(tool, at(edge - 1e-6, kReach - 1e-3), 1e-3).pairs == 1);
  CHECK(inside.tick(tool, at(edge + 1e-6, kReach - 1e-3), 1e-3).pairs == 0);
}

TEST_CASE("a released string rings as Eq. 9 says, and with a tank gives no more than it has") {
  StringParameters parameters;
  parameters.p_WA = {-0.55, 0.0, 0.0};
  parameters.p_WB = {0.55, 0.0, 0.0};
  parameters.frequency = 100.0;
  const StringConstants string = derive_string(parameters);
  PrintedVibration free;
  free.advance(string, 4e-3, 0.25, 1e-3);
  free.advance(string, 2e-3, 0.25, 1e-3);
  free.advance(string, -1.0, 0.5, 1e-3);
  CHECK(free.radius(string) == doctest::Approx(4e-3));
  const double E0 = std::numbers::pi * std::numbers::pi * 30.0 * 16e-6 / (4.0 * kLength);
  CHECK(free.energy(string) == doctest::Approx(E0));
  // A quarter of a period later, touched again.
  free.advance(string, 0.0, 0.25, 2.5e-3);
  const double k_v = 30.0 / (kLength * 0.25 * 0.75);
  CHECK(free.force(string, {}, 0.0, 1e-3) ==
        doctest::Approx(k_v * 4e-3 * std::exp(-2.5e-3 / string.decay)));

  // A hand that swings with the string, 1 mm: without a tank it draws far more than there is.
  for (const bool tank : {false, true}) {
    PrintedVibration vibration;
    vibration.advance(string, 1e-3, 0.5, 1e-3);
    vibration.advance(string, -1.0, 0.5, 1e-3);
    const double energy = vibration.energy(string);
    double given = 0.0;
    double force = 0.0;
    double place = 0.0;
    for (int k = 1; k < 2000; ++k) {
      const double here = -1e-3 * std::cos(2.0 * std::numbers::pi * 100.0 * 1e-3 * k);
      given += force * (here - place);
      vibration.advance(string, 0.0, 0.5, 1e-3);
      force = vibration.force(string, {tank}, here - place, 1e-3);
      place = here;
    }
    if (tank) {
      CHECK(given <= energy + 50e-6 + 1e-12);
    } else {
      CHECK(given > 3.0 * energy);
    }
  }
}

TEST_CASE("only what is led through has popped: not what slips round a string or grazes it") {
  const Scene scene(finger_and_string());
  const ToolScene tool = scene.tool_scene(0);
  // Half a turn around it, a little sunk in.
  PopThroughWatch around(tool);
  bool popped = false;
  Pose X_WG = at(0.0, 2.0 * kReach);
  for (int k = 0; k <= 180; ++k) {
    const double angle = std::numbers::pi * k / 180.0;
    const double r = 0.98 * kReach;
    const Pose next = at(0.0, r * std::cos(angle), r * std::sin(angle));
    popped = around.go(X_WG, next)[0] || popped;
    X_WG = next;
  }
  popped = around.go(X_WG, at(0.0, -2.0 * kReach))[0] || popped;
  CHECK(!popped);
  PopThroughWatch graze(tool);
  CHECK(!graze.go(at(0.0, 0.1, 0.8 * kReach), at(0.0, -0.1, 0.8 * kReach))[0]);
  PopThroughWatch through(tool);
  CHECK(through.go(at(0.0, 0.1, 0.3 * kReach), at(0.0, -0.1, 0.3 * kReach))[0]);
  // In and out again on the side it came from.
  PopThroughWatch back(tool);
  CHECK(!back.go(at(0.0, 0.1), at(0.0, -1e-3))[0]);
  CHECK(!back.go(at(0.0, -1e-3), at(0.0, 0.1))[0]);
}

TEST_CASE("a table of poses that is none is refused with file and line") {
  const TemporaryFolder folder;
  const std::string head = "t_s,x,y,z,qw,qx,qy,qz\n";
  const auto said = [&](const std::string& text) {
    try {
      (void)read_poses(folder.write("p.csv", text));
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(read_poses(folder.write("p.csv", head + "0,1,2,3,1,0,0,0\n")).front().X_DH.p.z() == 3.0);
  CHECK(said("a,b\n").find("p.csv:1: the columns are not t_s,x") != std::string::npos);
  CHECK(said(head + "0,1,2,3,1,0,0\n").find("p.csv:2: not eight") != std::string::npos);
  CHECK(said(head + "0,1,2,nan,1,0,0,0\n").find("p.csv:2: not eight") != std::string::npos);
  CHECK(said(head + "0,1,2,3,9,0,0,0\n").find("p.csv:2: a quaternion") != std::string::npos);
  CHECK(said(head + "0,1,2,3,1,0,0,0\n0,1,2,3,1,0,0,0\n").find("p.csv:3: time") !=
        std::string::npos);
  CHECK(said(head).find("has no pose") != std::string::npos);
}

}  // namespace hapticd::test
