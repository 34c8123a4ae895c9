// Plays one period of a scene and motion of tick_scene.h in a function whose instructions callgrind
// counts; run by tests/benchmark/count_instructions. usage: contact_tick_instructions SCENE MOTION
#include <cstdio>
#include <cstring>

#include "tests/benchmark/tick_scene.h"

namespace hapticd::test {

/// Callgrind collects between its entry and its return.
[[gnu::noinline]] void counted_ticks(TickScene& scene) {
  for (int k = 0; k < kPeriodTicks; ++k) scene.tick();
}

}  // namespace hapticd::test

int main(int argc, char** argv) {
  using namespace hapticd::test;
  for (const NamedParts& scene : timed_scenes()) {
    for (const NamedMotion& motion : timed_motions()) {
      if (argc != 3 || std::strcmp(argv[1], scene.name) != 0 ||
          std::strcmp(argv[2], motion.name) != 0) {
        continue;
      }
      TickScene played(scene.parts(), motion.motion);
      counted_ticks(played);
      std::printf("%d ticks\n", kPeriodTicks);
      return 0;
    }
  }
  std::fprintf(
      stderr,
      "usage: contact_tick_instructions SCENE MOTION, as named by benchmark_contact_tick\n");
  return 2;
}
