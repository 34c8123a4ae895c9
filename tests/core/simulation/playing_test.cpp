// Playing through the whole tick: plucks, presses, sweeps, and the tones they give.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/core/simulation/simulation_fixture.h"

namespace hapticd::test {

TEST_CASE("five plucks of a string that yields give five releases and five tones") {
  Instrument guqin(1, StringParameters{}, InstrumentOptions{});
  guqin.tick({0.33, 0.02, -0.012});
  for (int i = 0; i < 5; ++i) {
    // Under the string, across it, and back above it.
    guqin.glide({0.33, -2e-3, -0.012}, 0.2, [](const TickOutput&) {});
    guqin.glide({0.33, -2e-3, 0.015}, 0.3, [](const TickOutput&) {});
    guqin.glide({0.33, 0.02, 0.015}, 0.3, [](const TickOutput&) {});
    guqin.glide({0.33, 0.02, -0.012}, 0.3, [](const TickOutput&) {});
  }
  CHECK(count(guqin.events, StringEventKind::kRelease) == 5);
  CHECK(count(guqin.events, StringEventKind::kTone) == 5);
}

}  // namespace hapticd::test
