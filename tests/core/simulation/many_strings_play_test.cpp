// A rake that plays more strings at once than the dense program has room for: every string sounds
// when it is let go, as it does alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/simulation/simulation_fixture.h"

namespace hapticd::test {
namespace {

constexpr double kPlace = 0.33;
constexpr double kSpeed = 0.3;

/// A tooth for each of `strings` strings, the first of them at the origin of the tool.
std::vector<Sphere> rake(int strings) {
  std::vector<Sphere> teeth;
  teeth.reserve(static_cast<std::size_t>(strings));
  for (int k = 0; k < strings; ++k) teeth.push_back({{0.0, 0.0, 0.02 * k}, kFingertip});
  return teeth;
}

/// From above down between the strings, across under their height until all have slipped off, and
/// up again; the largest force on the way, N.
double pluck(Instrument& guqin) {
  double largest = 0.0;
  const auto watch = [&largest](const SimulationTick& output) {
    CHECK(output.tool(0).contact.strings_refused == 0);
    largest = std::max(largest, output.tool(0).F_computed_H_W.f.norm());
  };
  guqin.p_WH = {kPlace, 0.02, -8e-3};
  guqin.tick(guqin.p_WH);
  guqin.glide({kPlace, -1e-3, -8e-3}, kSpeed, watch);
  guqin.glide({kPlace, -1e-3, 10e-3}, kSpeed, watch);
  guqin.glide({kPlace, 0.02, 10e-3}, kSpeed, watch);
  return largest;
}

}  // namespace

TEST_CASE("a rake that plucks many strings at once makes each of them sound once") {
  Instrument one(1, StringParameters{}, InstrumentOptions{}, rake(1));
  one.scene().stiffness = {1000.0, 1.0};
  const double alone = pluck(one);
  CHECK(count(one.events, StringEventKind::kTone) == 1);
  for (const int strings : {9, 16, 21}) {
    Instrument guqin(strings, StringParameters{}, InstrumentOptions{}, rake(strings));
    // As stiff for each string as the hand is that plucks one.
    guqin.scene().stiffness = {1000.0 * strings, 1.0};
    const double together = pluck(guqin);
    const std::vector<StringEvent> tones = of_kind(guqin.events, StringEventKind::kTone);
    CAPTURE(strings);
    MESSAGE(strings << " strings: " << tones.size() << " tones, " << together << " N, one alone "
                    << alone << " N");
    REQUIRE(tones.size() == static_cast<std::size_t>(strings));
    for (int k = 0; k < strings; ++k) {
      CHECK(std::count_if(tones.begin(), tones.end(),
                          [k](const StringEvent& tone) { return tone.string == k; }) == 1);
    }
    CHECK(together > 0.5 * alone * strings);
  }
}

TEST_CASE("the same rake stroke twice gives the same bits") {
  Instrument a(16, StringParameters{}, InstrumentOptions{}, rake(16));
  Instrument b(16, StringParameters{}, InstrumentOptions{}, rake(16));
  const double largest = pluck(a);
  CHECK(largest > 0.1);
  CHECK(pluck(b) == largest);
  const ContactState& one = a.simulation().memory().tools[0].state.contact;
  const ContactState& other = b.simulation().memory().tools[0].state.contact;
  CHECK(one.X_WG.p == other.X_WG.p);
  CHECK(a.events.size() == b.events.size());
}

}  // namespace hapticd::test
