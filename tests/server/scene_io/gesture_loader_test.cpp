// Gestures: what is refused, with its place and remedy; where way-points at strings lie, from the
// definition of the string's frame; how long a way at a speed takes.
#include "server/scene_io/gesture_loader.h"
#include "server/scene_io/named_text.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/math/rotation.h"
#include "server/scene_io/gesture_motion.h"
#include "tests/server/scene_io/inline_text.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

std::string track(const std::string& waypoints) {
  return "name: \"g\"\ntracks {\n" + waypoints + "}\n";
}

/// The faults of a text, one line each.
std::string faults(const std::string& text) {
  const GestureResult result = load_gesture_text(text);
  CHECK(result.gesture.has_value() == !any_fault(result.problems));
  std::string lines;
  for (const SceneProblem& problem : result.problems) lines += to_text(problem) + "\n";
  return lines;
}

/// Two strings: one along x, one leaning; the tool begins at a turned pose.
SceneDescription two_strings() {
  SceneDescription scene;
  scene.name = "two";
  scene.tools.resize(1);
  scene.tools[0].X_WG = {exp_rotation({0.0, 0.3, 0.0}), {0.0, 1.0, 0.0}};
  scene.strings.resize(2);
  scene.strings[0].parameters.p_WA = {1.0, 0.0, 0.0};
  scene.strings[0].parameters.p_WB = {-1.0, 0.0, 0.0};
  scene.strings[1].parameters.p_WA = {0.0, 0.0, 0.0};
  scene.strings[1].parameters.p_WB = {3.0, 4.0, 0.0};
  return scene;
}

Pose unchanged(const Pose& X_WH) { return X_WH; }

MotionResult resolve(const std::string& text, const PoseToDevice& to_device = unchanged) {
  const GestureResult result = load_gesture_text(text);
  REQUIRE(result.gesture.has_value());
  return resolve_gesture(*result.gesture, 0, two_strings(), to_device);
}

}  // namespace

TEST_CASE("a fault in a gesture names line, column, field and remedy") {
  const std::string text =
      faults(track("  waypoints { pose_wh {} }\n  waypoints { pose_wh {} }\n"));
  CHECK(text.find("inline:4:3: error: tracks[0].waypoints[1]: the time to get here is missing") !=
        std::string::npos);
  CHECK(text.find("Give duration_s or speed_m_per_s.") != std::string::npos);
}

TEST_CASE("gestures that break what the comments of gesture.proto promise are refused") {
  const std::string begin = "waypoints { pose_wh {} } ";
  const std::pair<std::string, std::string> cases[] = {
      {"tracks { waypoints { pose_wh {} } }", "name"},
      {"name: \"A b\" tracks { waypoints { pose_wh {} } }", "not a name for a gesture"},
      {"name: \"g\"", "tracks"},
      {track(""), "neither way-points nor a path"},
      {track(begin + "path { rate_hz: 10 p_wh_m: [0,0,0,1,1,1] }"), "both"},
      {track("waypoints { duration_s: 1 }"), "without a place"},
      {track("waypoints { pose_wh {} duration_s: 1 }"), "takes no time"},
      {track(begin + "waypoints { pose_wh {} duration_s: 0 }"), "(0, 3600]"},
      {track(begin + "waypoints { pose_wh {} duration_s: 3601 }"), "(0, 3600]"},
      {track(begin + "waypoints { pose_wh {} speed_m_per_s: -1 }"), "(0, 1000]"},
      {track("waypoints { pose_wh {} hold_s: nan }"), "hold_s"},
      {track("waypoints { pose_wh { p_m: [0, 1] } }"), "2 numbers"},
      {track("waypoints { pose_wh { q: [0, 0, 0, 0] } }"), "norm"},
      {track("waypoints { at_string { lambda: 1.01 } }"), "[0, 1]"},
      {track("waypoints { at_string { offset_m: [0, 11, 0] } }"), "[-10, 10]"},
      {track("waypoints { at_string { string_index: 1024 } }"), "[0, 1023]"},
      {track("path { rate_hz: 10 p_wh_m: [0, 0, 0] }"), "fewer than two"},
      {track("path { rate_hz: 0.5 p_wh_m: [0,0,0, 1,1,1] }"), "[1, 1e5]"},
      {track("path { rate_hz: 10 p_wh_m: [0, 0, 0, 1] }"), "4 numbers"},
      {track("path { rate_hz: 10 p_wh_m: [0,0,0, 1,1,1] q_wh: [1,0,0,0] }"), "1 orientations"},
      {track("path { rate_hz: 10 p_wh_m: [0,0,0, 1,1,1] q_wh: [1,0,0,0, 0,0,0,0.1] }"), "norm"},
      {track("waypoints { pose_wh {} interpolation: 7 }"), "interpolation"},
      {"name: \"g\" tracks { waypoints { pose_wh {} } } tracks { waypoints { pose_wh {} } }",
       "second track"},
      {"name: \"g\" tracks { waypoints { pose", "inline:1"},
      {"name: \"g\" wood: 1", "wood"},
  };
  for (const auto& each : cases) {
    const std::string text = each.first;
    const std::string found = faults(text);
    CAPTURE(text);
    CAPTURE(found);
    CHECK(found.find(each.second) != std::string::npos);
  }
}

TEST_CASE("a gesture that is not there is answered with those that are") {
  const GestureResult result = load_gesture("nope", {HAPTICD_SOURCE_DIR "/deploy/gestures"});
  REQUIRE(result.problems.size() == 1);
  CHECK(to_text(result.problems[0]).find("Installed are bunny_line_and_pillar, bunny_") !=
        std::string::npos);
}

TEST_CASE("every shipped gesture loads without a doubt, under its own name") {
  const GestureFolders folders{HAPTICD_SOURCE_DIR "/deploy/gestures"};
  const std::vector<std::string> names = list_names(folders);
  CHECK(names.size() >= 28);
  for (const std::string& name : names) {
    const GestureResult result = load_gesture(name, folders);
    CAPTURE(name);
    REQUIRE(result.gesture.has_value());
    CHECK(result.problems.empty());
    CHECK(result.gesture->name() == name);
    CHECK(!result.gesture->description().empty());
  }
}

TEST_CASE("the frame at a string has x from A to B, y up made normal to x, z = x cross y") {
  SplitMix64 random(5);
  for (std::int64_t i = 0; i < scaled(10'000); ++i) {
    const Vector3 p_WA = to_vector(random.direction());
    const Vector3 p_WB = p_WA + 2.0 * to_vector(random.direction());
    const Matrix3 R = string_frame(p_WA, p_WB);
    REQUIRE((R * R.transpose() - Matrix3::Identity()).norm() < 1e-9);
    REQUIRE(R.determinant() > 0.0);
    REQUIRE(R.col(0).cross(p_WB - p_WA).norm() < 1e-12);
    REQUIRE(R.col(0).dot(p_WB - p_WA) > 0.0);
    // No other direction normal to the string is steeper.
    REQUIRE(std::abs(R.col(2).y()) < 1e-9);
    REQUIRE(R.col(1).y() >= 0.0);
  }
  const Matrix3 upright = string_frame({0, 0, 0}, {0, 2, 0});
  CHECK((upright.col(1) - Vector3(0, 0, -1)).norm() < 1e-15);
}

TEST_CASE("a way-point at a string lies at its lambda and offset, turned as the one before") {
  const MotionResult result = resolve(
      track("waypoints { at_string { lambda: 0.25 offset_m: [0.01, 0.02, 0.03] } }"
            "waypoints { at_string { string_index: 1 lambda: 0.5 offset_m: [0, 0.5, 0] "
            "q_wh: [0.5, 0.5, 0.5, 0.5] } duration_s: 2 hold_s: 0.25 }"
            "waypoints { at_string { } duration_s: 1 interpolation: INTERPOLATION_LINEAR }"));
  REQUIRE(result.motion.has_value());
  const std::vector<GestureLeg>& legs = result.motion->legs;
  REQUIRE(legs.size() == 3);
  // String 0 runs along -x: its x axis is -x of the world, its z axis -z.
  CHECK((to_vector(legs[0].point.p_DH) - Vector3(0.49, 0.02, -0.03)).norm() < 1e-15);
  CHECK((log_rotation(to_quaternion(legs[0].point.q_DH)) - Vector3(0, 0.3, 0)).norm() < 1e-14);
  // String 1 rises 3:4; up made normal to it is (-4, 3, 0) / 5.
  CHECK((to_vector(legs[1].point.p_DH) - Vector3(1.5 - 0.4, 2.0 + 0.3, 0)).norm() < 1e-14);
  CHECK(legs[1].point.q_DH == Array4{0.5, 0.5, 0.5, 0.5});
  CHECK(legs[1].duration_ns == 2'000'000'000);
  CHECK(legs[1].hold_ns == 250'000'000);
  CHECK(!legs[1].linear);
  CHECK(legs[2].point.q_DH == Array4{0.5, 0.5, 0.5, 0.5});
  CHECK(legs[2].linear);
}

TEST_CASE("a speed is the peak along the straight way: 15/8 of the mean, or the mean when linear") {
  const MotionResult result = resolve(
      track("waypoints { pose_wh {} }"
            "waypoints { pose_wh { p_m: [0.3, 0.4, 0] } speed_m_per_s: 0.25 }"
            "waypoints { pose_wh {} speed_m_per_s: 0.25 interpolation: INTERPOLATION_LINEAR }"));
  REQUIRE(result.motion.has_value());
  CHECK(result.motion->legs[1].duration_ns == 3'750'000'000);
  CHECK(result.motion->legs[2].duration_ns == 2'000'000'000);
}

TEST_CASE("way-points that fit no scene are refused: no such string, a turn on the spot by speed") {
  const MotionResult no_string = resolve(track("waypoints { at_string { string_index: 2 } }"));
  CHECK(!no_string.motion.has_value());
  REQUIRE(no_string.problems.size() == 1);
  CHECK(no_string.problems[0].field == "tracks[0].waypoints[0].at_string.string_index");
  const MotionResult turn = resolve(
      track("waypoints { pose_wh {} } waypoints { pose_wh { q: [0, 1, 0, 0] } speed_m_per_s: 1 }"));
  CHECK(!turn.motion.has_value());
  const MotionResult slow = resolve(track(
      "waypoints { pose_wh {} } waypoints { pose_wh { p_m: [1e7, 0, 0] } speed_m_per_s: 1e-9 }"));
  CHECK(!slow.motion.has_value());
}

TEST_CASE("every pose goes to the device through the map; other tools' tracks do not concern it") {
  const auto shifted = [](const Pose& X_WH) { return Pose{X_WH.q, X_WH.p - Vector3(0, 1, 0)}; };
  const MotionResult way = resolve(track("waypoints { pose_wh { p_m: [1, 2, 3] } }"), shifted);
  CHECK(way.motion->legs[0].point.p_DH == Array3{1, 1, 3});
  const MotionResult path = resolve(track("path { rate_hz: 20 p_wh_m: [0,1,0, 1,2,1] }"), shifted);
  REQUIRE(path.motion->samples.size() == 2);
  CHECK(path.motion->rate == 20.0);
  CHECK(path.motion->samples[1].p_DH == Array3{1, 1, 1});
  CHECK(path.motion->samples[1].q_DH == Array4{1, 0, 0, 0});
  const MotionResult other = resolve("name: \"g\" tracks { tool_id: 3 waypoints { pose_wh {} } }");
  CHECK(!other.motion.has_value());
  CHECK(other.problems.empty());
}

}  // namespace hapticd::test
