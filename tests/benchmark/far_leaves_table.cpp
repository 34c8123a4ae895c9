// What a body of a million leaves costs a tick while it is out of reach: whole ticks of a finger
// that is free, and of one that presses a string, without the body and with it, in turn in the same
// run. Prints a markdown table; a time is the median over batches of ticks, of the thread. The
// scene takes some seconds to build. usage: far_leaves_table
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <memory>
#include <vector>

#include "core/math/elementary.h"
#include "core/scene/scene.h"
#include "tests/core/scene/scene_builder.h"
#include "tests/support/contact_scenes.h"
#include "tests/support/simulation_tick.h"

namespace hapticd::test {
namespace {

/// Leaves along each side of the body.
constexpr int kSide = 1000;
constexpr int kBatches = 400;
constexpr int kTicksPerBatch = 250;
/// Height at which the finger just touches the string, m.
constexpr double kTouch = 5e-3 + 0.34e-3;
/// Most that is asked for, us.
constexpr double kAsked_us = 0.5;

double thread_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

Scene scene_of(bool body) {
  SceneDescription scene = finger_scene({0.33, 0.1, 0.0});
  StringDescription string = string_between(Vector3::Zero(), Vector3(1.1, 0.0, 0.0));
  string.parameters.frequency = 98.0;
  scene.strings.push_back(string);
  if (body) {
    BodyDescription far;
    far.name = "slab";
    far.shape = shape_of(slab_spheres(kSide, kSide));
    far.X_WB.p = {0.33, -0.1, 0.0};
    scene.bodies.push_back(far);
  }
  return Scene(std::move(scene));
}

/// A scene played at one height.
struct Run {
  Run(const Scene& scene, double height) : play(scene.simulate(0)), y(height) {
    for (int k = 0; k <= 100; ++k) tick(0.1 + (y - 0.1) * k / 100.0);
  }

  void tick(double height) {
    t_ns += 1'000'000;
    output.step(*play.simulation, {t_ns, {0.33, height, 0.0}, {1.0, 0.0, 0.0, 0.0}});
  }
  /// Per tick, ns; the finger goes 0.5 mm up and down.
  double batch() {
    const double before = thread_ns();
    for (int k = 0; k < kTicksPerBatch; ++k) {
      tick(y + 0.5e-3 * sin_cos(2.0 * kPi * k / kTicksPerBatch).sin);
    }
    return (thread_ns() - before) / kTicksPerBatch;
  }

  OwnedSimulation play;
  SimulationTick output;
  std::int64_t t_ns = 0;
  double y;
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void print(const char* what, double height, const Scene& without, const Scene& with) {
  Run a(without, height);
  Run b(with, height);
  std::vector<double> times_a;
  std::vector<double> times_b;
  std::vector<double> added;
  for (int k = 0; k < kBatches; ++k) {
    times_a.push_back(a.batch());
    times_b.push_back(b.batch());
    added.push_back(times_b.back() - times_a.back());
  }
  const double more_us = 1e-3 * median(added);
  std::printf("| %s | %.3f | %.3f | %.3f | %s |\n", what, 1e-3 * median(times_a),
              1e-3 * median(times_b), more_us, more_us <= kAsked_us ? "met" : "**not met**");
}

void run() {
  const Scene without = scene_of(false);
  const Scene with = scene_of(true);
  std::printf("| finger and string | tick us | with %zu far leaves us | more us | asked %g |\n",
              with.body_spheres(), kAsked_us);
  std::printf("|---|---:|---:|---:|---|\n");
  print("free, 50 mm above", kTouch + 0.05, without, with);
  print("pressing the string", kTouch - 2e-3, without, with);
}

}  // namespace
}  // namespace hapticd::test

int main() {
  try {
    hapticd::test::run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "far_leaves_table: %s\n", error.what());
    return 1;
  }
}
