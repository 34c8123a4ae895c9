// Our whole tick beside MuJoCo's mj_step on the same scene and poses, in one run: plays of
// shipped_play.h, the ticks in which our tool presses something. Strings are rigid capsules there,
// and nothing rings; bodies are their spheres, and where a body is the slab, eight boxes too, which
// MuJoCo likes best. Prints a markdown table. --quick plays less.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "core/collision/primitive_gap.h"
#include "tests/benchmark/peers/mujoco_scene.h"
#include "tests/benchmark/shipped_play.h"
#include "tests/benchmark/tick_times.h"

namespace hapticd::test {
namespace {

/// The first tool and all obstacles as plain spheres and capsules.
TickParts parts_of(const Scene& scene) {
  const ToolScene view = scene.tool_scene(0);
  TickParts parts;
  for (std::size_t i = 0; i < view.tool.leaf_r.size(); ++i) {
    parts.tool_G.push_back(view.tool.leaf(static_cast<std::int32_t>(i)));
  }
  parts.capsules_W.assign(view.obstacles.capsules_W.begin(), view.obstacles.capsules_W.end());
  for (const BodyView& body : view.obstacles.bodies) {
    const Matrix3 R_WB = rotation_matrix(body.X_WB.q);
    for (std::size_t i = 0; i < body.tree.leaf_r.size(); ++i) {
      const Sphere leaf = body.tree.leaf(static_cast<std::int32_t>(i));
      parts.body_W.push_back({rotate(R_WB, leaf.p) + body.X_WB.p, leaf.r});
    }
  }
  return parts;
}

/// Times of the ticks in which our tool presses, us, of the first `ticks` of the play.
struct Ours {
  std::vector<double> us;
  std::vector<std::size_t> pressing;
};

Ours play_ours(ShippedPlay& play, std::size_t ticks) {
  Ours ours;
  for (std::size_t k = 0; k < ticks; ++k) {
    const double before = thread_microseconds();
    play.step();
    const double us = thread_microseconds() - before;
    if (play.work().active == 0) continue;
    ours.us.push_back(us);
    ours.pressing.push_back(k);
  }
  return ours;
}

double play_mujoco(const ShippedPlay& play, const Ours& ours, std::size_t most,
                   const MujocoSettings& settings) {
  MujocoScene mujoco(parts_of(play.scene()), play.scene().tool_scene(0).stiffness, settings);
  const std::size_t first = ours.pressing.front() > 20 ? ours.pressing.front() - 20 : 0;
  mujoco.place(play.poses()[first]);
  std::vector<double> us;
  for (std::size_t k = first; k <= ours.pressing.back() && us.size() < most; ++k) {
    const double before = thread_microseconds();
    mujoco.tick(play.poses()[k]);
    const double time = thread_microseconds() - before;
    if (std::binary_search(ours.pressing.begin(), ours.pressing.end(), k)) us.push_back(time);
  }
  return quantile(us, 0.5);
}

struct Row {
  const char* play;
  std::size_t ticks;  ///< of MuJoCo
  bool slab;
};
constexpr Row kRows[] = {{"hand36/press", 1000, true},
                         {"hand36/sweep", 1000, true},
                         {"guqin/strum", 60, false},
                         {"stress/press", 30, false}};

void print(const Row& row, bool quick) {
  const auto names = shipped_plays();
  const auto name = std::find_if(names.begin(), names.end(), [&](const ShippedPlayName& n) {
    return std::strcmp(n.name, row.play) == 0;
  });
  ShippedPlay play(*name);
  const Ours ours = play_ours(play, play.ticks());
  const double our_us = quantile(ours.us, 0.5);
  const std::size_t most = quick ? std::max<std::size_t>(row.ticks / 10, 5) : row.ticks;
  const auto line = [&](const char* what, const MujocoSettings& settings) {
    double us = 0.0;
    try {
      us = play_mujoco(play, ours, most, settings);
    } catch (const std::exception& error) {
      std::string reason = error.what();
      reason.erase(std::remove(reason.begin(), reason.end(), '\n'), reason.end());
      std::printf("| %s | %.1f | %s | %s | |\n", name->what, our_us, what, reason.c_str());
      return;
    }
    std::printf("| %s | %.1f | %s | %.1f | %.1f |\n", name->what, our_us, what, us, us / our_us);
    std::fflush(stdout);
  };
  line("spheres, contact 2 ms, Newton", {.contact_time = 2e-3});
  if (row.slab) {
    line("8 boxes, contact 2 ms, Newton", {.body_as_boxes = true, .contact_time = 2e-3});
  }
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  std::printf(
      "| play | hapticd p50 us | MuJoCo, body of | mj_step p50 us | times ours |\n"
      "|---|---:|---|---:|---:|\n");
  try {
    for (const hapticd::test::Row& row : hapticd::test::kRows) hapticd::test::print(row, quick);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mujoco_scenes_table: %s\n", error.what());
    return 1;
  }
}
