// Plays a motion of shipped_play.h and steps the ticks that press something (all, where none does)
// in a function whose instructions callgrind counts; run by tests/benchmark/count_instructions.
// usage: shipped_instructions SCENE MOTION
#include <cstdio>
#include <exception>
#include <string>

#include "tests/benchmark/shipped_play.h"

namespace hapticd::test {

/// Callgrind collects between its entry and its return.
[[gnu::noinline]] void counted_ticks(ShippedPlay& play) { play.step(); }

std::size_t play_counted(ShippedPlay& play) {
  std::vector<bool> presses;
  std::size_t pressing = 0U;
  for (std::size_t k = 0; k < play.ticks(); ++k) {
    play.step();
    presses.push_back(play.work().active > 0);
    if (presses.back()) ++pressing;
  }
  play.restart();
  for (std::size_t k = 0; k < play.ticks(); ++k) {
    if (pressing == 0 || presses[k]) {
      counted_ticks(play);
    } else {
      play.step();
    }
  }
  return pressing == 0 ? play.ticks() : pressing;
}

}  // namespace hapticd::test

int main(int argc, char** argv) {
  using namespace hapticd::test;
  try {
    for (const ShippedPlayName& name : shipped_plays()) {
      if (argc != 3 || std::string(argv[1]) + '/' + argv[2] != name.name) continue;
      ShippedPlay play(name);
      std::printf("%zu ticks\n", play_counted(play));
      return 0;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  std::fprintf(stderr, "usage: shipped_instructions SCENE MOTION, one of\n");
  for (const ShippedPlayName& name : shipped_plays()) std::fprintf(stderr, "  %s\n", name.name);
  return 2;
}
