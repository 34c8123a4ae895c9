// The path of a gesture: where it begins and ends, and its shape against Flash and Hogan's
// polynomial.
#include "tests/oracle/gesture_path.h"
#include "tests/support/within.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

namespace hapticd::test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

GesturePoint at(double x) { return {{x, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}; }

GestureLeg leg(double x, std::int64_t duration_ms, std::int64_t hold_ms, bool linear = false) {
  return {at(x), duration_ms * kMillisecond, hold_ms * kMillisecond, linear};
}

}  // namespace

TEST_CASE("a path begins at the first way-point and ends when the last rest is over") {
  GestureMotion motion;
  motion.legs = {leg(1.0, 0, 20), leg(3.0, 100, 30)};
  const std::vector<TimedPose> poses = follow_track(motion.track(), kMillisecond);
  REQUIRE(poses.size() == 151);
  CHECK(poses.front().t_ns == 0);
  CHECK(poses.front().X_DH.p.x() == 1.0);
  CHECK(poses[19].X_DH.p.x() == 1.0);
  CHECK(poses[120].X_DH.p.x() == 3.0);
  CHECK(poses.back().t_ns == 150 * kMillisecond);
  CHECK(poses.back().X_DH.p.x() == 3.0);
}

TEST_CASE("between way-points a path has minimum jerk, or constant speed where asked") {
  GestureMotion motion;
  motion.legs = {leg(0.0, 0, 0), leg(2.0, 100, 0), leg(1.0, 50, 0, true)};
  const std::vector<TimedPose> poses = follow_track(motion.track(), kMillisecond);
  REQUIRE(poses.size() == 151);
  for (std::size_t k = 0; k < 100; ++k) {
    const double s = static_cast<double>(k) / 100.0;
    const double jerk = 10.0 * std::pow(s, 3) - 15.0 * std::pow(s, 4) + 6.0 * std::pow(s, 5);
    CHECK(poses[k].X_DH.p.x() == within(2.0 * jerk, 1e-12));
  }
  for (std::size_t k = 0; k <= 50; ++k) {
    CHECK(poses[100 + k].X_DH.p.x() == within(2.0 - static_cast<double>(k) / 50.0, 1e-12));
  }
}

TEST_CASE("a period that does not divide a path still reaches its end") {
  GestureMotion motion;
  motion.samples = {at(0.0), at(1.0), at(4.0)};
  motion.rate = 100.0;
  const std::vector<TimedPose> poses = follow_track(motion.track(), 3 * kMillisecond);
  REQUIRE(poses.size() == 8);
  CHECK(poses[2].X_DH.p.x() == doctest::Approx(0.6));
  CHECK(poses.back().t_ns == 21 * kMillisecond);
  CHECK(poses.back().X_DH.p.x() == 4.0);
}

TEST_CASE("a gesture without a track of the tool is refused by name") {
  SceneDescription scene;
  scene.name = "two";
  scene.tools.resize(1);
  ToolDescription& tool = scene.tools[0];
  tool.tool_id = 7;
  const std::string data = HAPTICD_DEPLOY_DIR;
  std::string said;
  try {
    (void)load_motion("roll", data, scene, tool);
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  CHECK(said.find("roll") != std::string::npos);
  CHECK(said.find("no track of tool 7") != std::string::npos);
  CHECK(said.find("--tool") != std::string::npos);
}

}  // namespace hapticd::test
