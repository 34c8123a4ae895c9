// Our contact tick beside MuJoCo's mj_step on the same scene and poses: a hand of 200 spheres,
// seven strings, a body of 4000 spheres, coupled with 800 N/m, 1 ms. Prints two markdown tables:
// what a tick costs and how deep the tool sinks in, judged by exhaustion; and how many strokes
// across a string go through it. --quick plays less.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>
#include <string>

#include "tests/benchmark/peers/mujoco_scene.h"
#include "tests/benchmark/tick_times.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr CouplingStiffness kStiffness{.kt = 800.0};
constexpr Motion kMotions[] = {Motion::kFree, Motion::kPress, Motion::kMove};

/// The hand of contact_scenes.h, finer: 60 spheres in the palm, 28 in each finger.
std::vector<Sphere> fine_hand() {
  constexpr int kPalmSpheres = 11;
  constexpr int kJoints = 5;
  constexpr int kFingerSpheres = 28;
  const std::vector<Sphere> coarse = hand_spheres();
  std::vector<Sphere> spheres;
  for (int i = 0; i < 60; ++i) {
    const int row = i / 10;
    spheres.push_back({{-0.030 + 0.060 * (i % 10) / 9.0, 0.0, 0.040 - 0.010 * row}, 0.014});
  }
  for (int finger = 0; finger < 5; ++finger) {
    for (int i = 0; i < kFingerSpheres; ++i) {
      const double s = (kJoints - 1.0) * i / (kFingerSpheres - 1.0);
      const int joint = std::min(static_cast<int>(s), kJoints - 2);
      const auto k = static_cast<std::size_t>(kPalmSpheres + kJoints * finger + joint);
      const double t = s - joint;
      spheres.push_back({(1.0 - t) * coarse[k].p + t * coarse[k + 1].p,
                         (1.0 - t) * coarse[k].r + t * coarse[k + 1].r});
    }
  }
  return spheres;
}

TickParts hand_scene() { return {fine_hand(), seven_strings(), slab_spheres(160, 25)}; }

/// What one motion of one renderer gave.
struct Timing {
  double mean_us;     ///< processor time of a tick
  double deepest_um;  ///< into strings or body, at the ticks that were judged
};

/// Times `periods` of the motion by `tick(k)`, then plays one more and judges poses of `X_WG()`.
Timing play(const RenderingScene& scene, int periods, const std::function<void(std::size_t)>& tick,
            const std::function<Pose()>& X_WG) {
  constexpr std::size_t kJudgedEvery = 10;
  const double start = thread_microseconds();
  for (int period = 0; period < periods; ++period) {
    for (std::size_t k = 0; k < kPeriodTicks; ++k) tick(k);
  }
  const double mean = (thread_microseconds() - start) / (periods * kPeriodTicks);

  long double deepest = 0.0L;
  for (std::size_t k = 0; k < kPeriodTicks; ++k) {
    tick(k);
    if (k % kJudgedEvery == 0) deepest = std::max(deepest, -scene.true_gap(X_WG()));
  }
  return {mean, 1e6 * static_cast<double>(deepest)};
}

Timing play_ours(Motion motion, int periods) {
  TickScene ours(hand_scene(), motion, kStiffness);
  Pose X_WG;
  return play(
      ours.scene(), periods, [&](std::size_t) { X_WG = ours.tick().X_WG; }, [&] { return X_WG; });
}

Timing play_mujoco(Motion motion, int periods, const MujocoSettings& settings) {
  const TickScene ours(hand_scene(), motion, kStiffness);
  MujocoScene mujoco(hand_scene(), kStiffness, settings);
  Pose above = ours.X_WH().front();
  above.p.y() += 0.02;
  mujoco.place(above);
  for (const Pose& X_WH : ours.X_WH()) mujoco.tick(X_WH);
  return play(
      ours.scene(), periods, [&](std::size_t k) { mujoco.tick(ours.X_WH()[k]); },
      [&] { return mujoco.X_WG(); });
}

struct NamedSettings {
  const char* name;
  MujocoSettings settings;
};

constexpr NamedSettings kVariants[] = {
    {"4000 spheres, contact 20 ms, Newton", {}},
    {"8 boxes, contact 20 ms, Newton", {.body_as_boxes = true}},
    {"8 boxes and strings in 3 links, contact 20 ms, Newton", {.body_as_boxes = true, .links = 3}},
    {"8 boxes, contact 2 ms, Newton", {.body_as_boxes = true, .contact_time = 2e-3}},
    {"8 boxes, contact 2 ms, CG", {.body_as_boxes = true, .contact_time = 2e-3, .solver = "CG"}},
    {"8 boxes, contact 2 ms, PGS", {.body_as_boxes = true, .contact_time = 2e-3, .solver = "PGS"}},
    {"8 boxes, contact 0.2 ms, Newton, 10 steps of 0.1 ms",
     {.body_as_boxes = true, .contact_time = 2e-4, .steps_per_tick = 10}},
};

void print_times(int periods) {
  std::printf(
      "| tick | free us | press us | move us | press, deepest um | move, deepest um | "
      "times ours, press | times ours, move |\n|---|---|---|---|---|---|---|---|\n");
  Timing ours[3];
  for (std::size_t k = 0; k < 3; ++k) ours[k] = play_ours(kMotions[k], periods);
  const auto print = [&](const char* name, const Timing(&t)[3]) {
    std::printf("| %s | %.1f | %.1f | %.1f | %.3g | %.3g | %.1f | %.1f |\n", name, t[0].mean_us,
                t[1].mean_us, t[2].mean_us, t[1].deepest_um, t[2].deepest_um,
                t[1].mean_us / ours[1].mean_us, t[2].mean_us / ours[2].mean_us);
    std::fflush(stdout);
  };
  print("**hapticd**", ours);
  for (const NamedSettings& variant : kVariants) {
    Timing mujoco[3];
    for (std::size_t k = 0; k < 3; ++k)
      mujoco[k] = play_mujoco(kMotions[k], periods, variant.settings);
    print((std::string("MuJoCo, ") + variant.name).c_str(), mujoco);
  }
}

/// A stroke of a fingertip straight across a string, held 50 mm behind it for 0.1 s.
std::vector<Pose> stroke(SplitMix64& random, double speed) {
  constexpr double kRunUp = 0.3;
  constexpr double kBehind = 0.05;
  constexpr int kHeldTicks = 100;
  const double z = random.uniform(-2.5e-3, 2.5e-3);
  const double offset = random.uniform(0.0, speed * 1e-3);
  std::vector<Pose> poses;
  for (double y = kRunUp + offset; y > -kBehind; y -= speed * 1e-3)
    poses.push_back(pose_at({0, y, z}));
  poses.insert(poses.end(), kHeldTicks, pose_at({0, -kBehind, z}));
  return poses;
}

/// Of the strokes of one renderer.
struct Crossings {
  int touched = 0;  ///< sank in by more than 1 um
  int through = 0;  ///< came out behind after sinking in by more than 1 mm
  double deepest_mm = 0.0;

  void count(long double gap, double y_end) {
    touched += gap < -1e-6L ? 1 : 0;
    through += gap < -1e-3L && y_end < 0.0 ? 1 : 0;
    deepest_mm = std::max(deepest_mm, -1e3 * static_cast<double>(gap));
  }
};

TickParts string_scene() {
  constexpr double kTip = 5e-3;
  constexpr double kString = 0.34e-3;
  return {{{{0, 0, 0}, kTip}}, {{{-0.55, 0, 0}, {0.55, 0, 0}, kString}}, {}};
}

Crossings strike_ours(const RenderingScene& scene, double speed, int strokes) {
  SplitMix64 random(1);
  Crossings out;
  for (int i = 0; i < strokes; ++i) {
    const std::vector<Pose> X_WH = stroke(random, speed);
    ToolRun run(scene, X_WH.front());
    run.stiffness = kStiffness;
    long double gap = 1.0L;
    for (const Pose& target : X_WH) gap = std::min(gap, run.tick_along(target));
    out.count(gap, run.state.X_WG.p.y());
  }
  return out;
}

Crossings strike_mujoco(const RenderingScene& scene, double speed, int strokes,
                        const MujocoSettings& settings) {
  SplitMix64 random(1);
  MujocoScene mujoco(string_scene(), kStiffness, settings);
  Crossings out;
  for (int i = 0; i < strokes; ++i) {
    const std::vector<Pose> X_WH = stroke(random, speed);
    mujoco.place(X_WH.front());
    long double gap = 1.0L;
    for (const Pose& target : X_WH) {
      const Pose before = mujoco.X_WG();
      mujoco.tick(target);
      gap = std::min(gap, scene.true_path_gap(before, mujoco.X_WG()));
    }
    out.count(gap, mujoco.X_WG().p.y());
  }
  return out;
}

void print_strokes(int strokes) {
  const TickParts parts = string_scene();
  RenderingScene scene(parts.tool_G);
  scene.capsules_W = parts.capsules_W;
  std::printf(
      "\n| %d strokes of a 5 mm tip across a 0.34 mm string | m/s | deeper than 1 um | through | "
      "deepest mm |\n|---|---|---|---|---|\n",
      strokes);
  const auto print = [](const char* name, double speed, const Crossings& c) {
    std::printf("| %s | %g | %d | %d | %.3g |\n", name, speed, c.touched, c.through, c.deepest_mm);
    std::fflush(stdout);
  };
  const NamedSettings settings[] = {
      {"MuJoCo, contact 20 ms", {}},
      {"MuJoCo, contact 2 ms", {.contact_time = 2e-3}},
      {"MuJoCo, contact 0.2 ms, 10 steps of 0.1 ms", {.contact_time = 2e-4, .steps_per_tick = 10}},
  };
  for (const double speed : {0.1, 1.0, 10.0}) {
    print("**hapticd**", speed, strike_ours(scene, speed, strokes));
    for (const NamedSettings& s : settings)
      print(s.name, speed, strike_mujoco(scene, speed, strokes, s.settings));
  }
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  try {
    hapticd::test::print_times(quick ? 1 : 5);
    hapticd::test::print_strokes(quick ? 20 : 200);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mujoco_table: %s\n", error.what());
    return 1;
  }
}
