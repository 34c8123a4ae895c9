// Recorded paths computed again: a session with changes of settings, faults, clutch and recentring
// comes to the same bits; one whose poses were touched is refused at the tick where they were.
#include "tests/oracle/path_check.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>

#include "tests/server/daemon/recorded_session.h"
#include "tests/server/model/temporary_folder.h"

namespace hapticd::test {
namespace {

struct Judged {
  SceneObjects objects;
  std::vector<JudgedTick> ticks;
  std::string refused;
};

Judged judge(const std::string& recording, std::optional<std::uint32_t> scene_id = {}) {
  Judged judged;
  try {
    check_path(
        {recording, {}, scene_id}, [&](const SceneObjects& objects) { judged.objects = objects; },
        [&](const JudgedTick& tick) { judged.ticks.push_back(tick); });
  } catch (const std::runtime_error& error) {
    judged.refused = error.what();
  }
  return judged;
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

double smallest_path_gap(const Judged& judged) {
  double smallest = kFarthestGap;
  for (const JudgedTick& tick : judged.ticks) smallest = std::min(smallest, tick.path_gap);
  return smallest;
}

}  // namespace

TEST_CASE("a recorded session comes to the same bits again, and never went into a string") {
  const TemporaryFolder folder;
  for (const bool virtual_time : {true, false}) {
    const std::string path = folder.path(virtual_time ? "virtual.mcap" : "real.mcap");
    record_session(path, virtual_time);
    const Judged judged = judge(path);
    CHECK(judged.refused == "");
    REQUIRE(judged.objects.names == std::vector<std::string>{"C2", "G2"});
    REQUIRE(judged.ticks.size() > 2000);
    CHECK(smallest_path_gap(judged) >= -1e-9);
    std::size_t on_string = 0;
    for (const JudgedTick& tick : judged.ticks) {
      const double gap = std::min(tick.gap_of_object[0], tick.gap_of_object[1]);
      // Nothing but the clearance of 20 um at most is between a string and the finger that presses
      // it.
      if (gap < 30e-6) ++on_string;
      CHECK(gap >= tick.path_gap - 1e-12);
    }
    CHECK(on_string > 100);
  }
}

TEST_CASE("the ticks of a later scene are judged on their own") {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.mcap");
  record_session(path, true);
  const Judged judged = judge(path, 2);
  CHECK(judged.refused == "");
  CHECK(judged.objects.names == std::vector<std::string>{"wall"});
  CHECK(judged.ticks.size() > 1000);
  CHECK(smallest_path_gap(judged) >= -1e-9);
  CHECK(says(judge(path, 3).refused, "a.mcap: it holds no tick of that scene"));
}

TEST_CASE("a pose that was touched by one bit is refused, with its tick") {
  const TemporaryFolder folder;
  record_session(folder.path("a.mcap"), true);
  copy_changed(folder.path("a.mcap"), folder.path("b.mcap"), [](v1::TickRecord& tick) {
    if (tick.tick() != 777) return true;
    v1::Pose& pose = *tick.mutable_outputs(0)->mutable_pose_wg();
    pose.set_p_m(1, std::nextafter(pose.p_m(1), 1.0));
    return true;
  });
  const Judged judged = judge(folder.path("b.mcap"));
  CHECK(says(judged.refused, "b.mcap: at tick 777"));
  CHECK(says(judged.refused, "Use the version that recorded it"));
}

TEST_CASE("a recording that lacks a tick, or its beginning, is refused") {
  const TemporaryFolder folder;
  record_session(folder.path("a.mcap"), true);
  copy_changed(folder.path("a.mcap"), folder.path("b.mcap"),
               [](v1::TickRecord& tick) { return tick.tick() != 500; });
  CHECK(says(judge(folder.path("b.mcap")).refused, "lost the ticks before number 501"));
  copy_changed(folder.path("a.mcap"), folder.path("c.mcap"),
               [](v1::TickRecord& tick) { return tick.tick() > 10; });
  CHECK(says(judge(folder.path("c.mcap")).refused, "its first tick of the scene is number 11"));
}

TEST_CASE("a stiffness that was another is refused, and so is what is no recording") {
  const TemporaryFolder folder;
  record_session(folder.path("a.mcap"), true);
  copy_changed(folder.path("a.mcap"), folder.path("b.mcap"), [](v1::TickRecord& tick) {
    tick.mutable_inputs(0)->set_stiffness_scale(0, 0.5);
    return true;
  });
  CHECK(says(judge(folder.path("b.mcap")).refused, "the stiffness was scaled by 0.5"));
  const std::string text = folder.write("text.mcap", "no recording");
  CHECK(says(judge(text).refused, "text.mcap: not a recording of hapticd"));
  CHECK(says(judge(folder.path("none.mcap")).refused, "none.mcap"));
}

}  // namespace hapticd::test
