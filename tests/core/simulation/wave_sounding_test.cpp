// What clients are told of strings that sound: a client that goes on by itself between the messages
// stays near what finite differences and closed forms say, and is told seldom.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "core/math/elementary.h"
#include "tests/core/simulation/ensemble.h"
#include "tests/core/simulation/wave_path.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Plays what it was told, as PROTOCOL.md says.
class Client {
 public:
  void hear(const std::vector<StringEvent>& events, std::size_t from) {
    bool plucked = false;
    for (std::size_t k = from; k < events.size(); ++k) {
      plucked = plucked || events[k].kind == StringEventKind::kTone;
      if (events[k].kind != StringEventKind::kSounding) continue;
      CHECK(events[k].number == (told_ ? told_->number + 1 : events[k].number));
      told_ = events[k];
      ++messages;
      // A pluck is told at once.
      if (!plucked) earliest = std::min(earliest, told_->t_ns - last_ns);
      last_ns = told_->t_ns;
    }
  }
  [[nodiscard]] bool sounds() const { return told_ && told_->partial_count > 0; }
  [[nodiscard]] const StringEvent& told() const { return *told_; }
  [[nodiscard]] double frequency(std::int64_t t_ns) const {
    const double since = std::min(1e-9 * static_cast<double>(t_ns - told_->t_ns), 0.1);
    return told_->frequency * std::exp2(told_->cents_per_s * since / 1200.0);
  }
  [[nodiscard]] double amplitude(std::size_t n, std::int64_t t_ns) const {
    const double since = 1e-9 * static_cast<double>(t_ns - told_->t_ns);
    return static_cast<double>(told_->partials[n - 1]) *
           std::exp(-since / static_cast<double>(told_->decays[n - 1]));
  }
  int messages = 0;
  std::int64_t earliest = std::int64_t{1} << 60;  ///< between two of them, ns
  std::int64_t last_ns = -(std::int64_t{1} << 60);

 private:
  std::optional<StringEvent> told_;
};

double cents(double frequency, double other) { return 1200.0 * std::log2(frequency / other); }
double decibels(double size, double other) { return 20.0 * std::log10(size / other); }

WaveScene random_scene(SplitMix64& random) {
  WaveScene scene;
  scene.tension = random.uniform(20.0, 60.0);
  scene.frequency = random.uniform(60.0, 200.0);
  scene.decay = random.uniform(0.3, 1.5);
  return scene;
}

TEST_CASE("an open string is told by a few messages, and decays at the client as on the grid") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < scaled(100); ++i) {
    const WaveScene scene = random_scene(random);
    GridPluck way;
    way.lambda = random.uniform(0.08, 0.45);
    way.speed = random.uniform(0.9, 1.5);
    way.finger.radius = scene.reach();
    const GridTone truth = pluck(grid_of(scene), way, 600);
    Instrument instrument = wave_instrument(scene);
    const double x = kWaveLength * way.lambda;
    instrument.tick(Vector3(x, way.height, -8e-3));
    Client client;
    std::size_t heard = 0;
    std::int64_t tone_ns = 0;
    const auto listen = [&](const SimulationTick&) {
      client.hear(instrument.events, heard);
      for (; heard < instrument.events.size(); ++heard) {
        const StringEvent& event = instrument.events[heard];
        if (event.kind == StringEventKind::kTone) tone_ns = event.t_ns;
      }
    };
    instrument.glide(Vector3(x, way.height, 60e-3), way.speed, listen);
    for (int k = 0; k < 400; ++k) listen(instrument.tick(instrument.p_WH));
    REQUIRE(tone_ns > 0);
    REQUIRE(client.sounds());
    const std::int64_t now = instrument.t_ns;
    CHECK(std::abs(cents(client.frequency(now), scene.frequency)) <= 2.0);
    CHECK(client.told().lambda == 0.0);
    CHECK(client.told().lambda_to == 1.0);
    // The truth's amplitude is of the end of its pluck; both decay in closed form since.
    const double since = 1e-9 * static_cast<double>(now) - 1e-9 * static_cast<double>(tone_ns);
    const double left = truth.amplitude * std::exp(-since / scene.decay);
    CHECK(std::abs(decibels(client.amplitude(1, now), left)) <= 0.7);
    CHECK(client.messages <= 4);
  }
}

TEST_CASE("a string that has rung out is told to be silent, once") {
  WaveScene scene;
  scene.decay = 0.1;
  Instrument instrument = wave_instrument(scene);
  instrument.tick(Vector3(0.11, 3e-3, -8e-3));
  Client client;
  std::size_t heard = 0;
  const auto listen = [&](const SimulationTick&) {
    client.hear(instrument.events, heard);
    heard = instrument.events.size();
  };
  instrument.glide(Vector3(0.11, 3e-3, 60e-3), 1.0, listen);
  CHECK(client.sounds());
  for (int k = 0; k < 1500; ++k) listen(instrument.tick(instrument.p_WH));
  CHECK_FALSE(client.sounds());
  CHECK(client.told().cause == SoundingCause::kDecay);
  CHECK(client.messages <= 6);
  const int messages = client.messages;
  for (int k = 0; k < 500; ++k) listen(instrument.tick(instrument.p_WH));
  CHECK(client.messages == messages);
}

/// A string that one tool stops, somewhere behind lambda 0.5, and another plucks.
struct Stopped {
  Stopped() : ensemble(2, options()) {}
  static EnsembleOptions options() {
    EnsembleOptions made;
    made.strings = 1;
    made.instrument = wave_options();
    WaveScene scene;
    scene.frequency = 65.4;
    scene.decay = 2.0;
    made.string = scene.string();
    return made;
  }
  void tick() {
    ensemble.tick({stop, finger});
    client.hear(ensemble.events, heard);
    heard = ensemble.events.size();
    t_ns += 1'000'000;
  }
  /// Presses with the stop, then plucks.
  void pluck(double lambda) {
    stop = {kEnsembleLength * lambda, 8e-3, 0.0};
    finger = {1.02, 3e-3, -12e-3};
    for (; stop.y() > 1e-3; stop.y() -= 0.05e-3) tick();
    for (int k = 0; k < 200; ++k) tick();
    for (; finger.z() < 30e-3; finger.z() += 1e-3) tick();
  }

  Ensemble ensemble;
  Vector3 stop, finger;
  Client client;
  std::size_t heard = 0;
  std::int64_t t_ns = 0;
};

/// Cents by which the client's pitch is off that of the part beyond the stop, at most.
double follow(Stopped& played, int ticks, const std::function<double(int)>& lambda_of) {
  double worst = 0.0;
  for (int k = 0; k < ticks; ++k) {
    const double lambda = lambda_of(k);
    played.stop.x() = kEnsembleLength * lambda;
    played.tick();
    const double off = cents(played.client.frequency(played.t_ns), 65.4 / (1.0 - lambda));
    worst = std::max(worst, std::abs(off));
  }
  return worst;
}

TEST_CASE("a stop that glides after the pluck is told: the client's pitch follows it") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < scaled(40); ++i) {
    const double from = random.uniform(0.3, 0.5);
    const double to = random.uniform(0.3, 0.5);
    // From 50 to 2000 cents a second.
    const double rate = 50.0 * std::pow(40.0, random.uniform());
    const double way = cents(1.0 - from, 1.0 - to);
    const int ticks = std::max(5, static_cast<int>(1e3 * std::abs(way) / rate));
    CAPTURE(from);
    CAPTURE(to);
    CAPTURE(rate);
    Stopped played;
    played.pluck(from);
    REQUIRE(played.client.sounds());
    const int before = played.client.messages;
    const double worst = follow(played, ticks + 200, [&](int k) {
      return 1.0 - (1.0 - from) * std::exp2(-way * std::min(1.0, (k + 1.0) / ticks) / 1200.0);
    });
    CHECK(worst <= (rate < 500.0 ? 3.0 : 1.0 + 4e-3 * rate));
    CHECK(played.client.sounds());
    CHECK(played.client.messages - before <= 4 + ticks / 10);
    CHECK(played.client.earliest >= 5'000'000);
  }
}

TEST_CASE("a stop that shakes is told by a hundred messages a second at most") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < scaled(40); ++i) {
    const double hertz = random.uniform(3.0, 8.0);
    const double size = random.uniform(2e-3, 10e-3);
    CAPTURE(hertz);
    CAPTURE(size);
    Stopped played;
    played.pluck(0.4);
    REQUIRE(played.client.sounds());
    const int before = played.client.messages;
    const double worst = follow(played, 1000, [&](int k) {
      return 0.4 + size / kEnsembleLength * std::sin(2e-3 * kPi * hertz * k);
    });
    CHECK(worst <= 3.5);
    CHECK(played.client.messages - before <= 100);
  }
}

TEST_CASE("what a soft finger damps is told as quiet at once") {
  // A skin of 25 N/m that damps, 1 mm deep, on an open string that rings.
  EnsembleOptions options = Stopped::options();
  options.string.frequency = 130.8;
  options.tuned = false;
  Ensemble ensemble(2, options);
  const std::vector<ToolPart> parts{{25.0, 0.2}};
  ensemble.simulation().scene(0).parts.parts = parts;
  const double reach = kEnsembleTip + options.string.radius;
  Vector3 skin(0.3 * kEnsembleLength, reach + 20e-3, 0.0);
  Vector3 finger(0.9 * kEnsembleLength, 3e-3, -12e-3);
  Client client;
  std::size_t heard = 0;
  std::int64_t t_ns = 0;
  const auto tick = [&] {
    ensemble.tick({skin, finger});
    client.hear(ensemble.events, heard);
    heard = ensemble.events.size();
    t_ns += 1'000'000;
  };
  for (; finger.z() < 30e-3; finger.z() += 1e-3) tick();
  for (int k = 0; k < 300; ++k) tick();
  const auto& state = ensemble.simulation().memory().waves.front().state;
  const double before = state.ringing;
  const double told = client.amplitude(1, t_ns);
  int late = 0;
  for (int k = 0; k < 300; ++k) {
    if (skin.y() > reach - 1e-3) skin.y() -= 0.2e-3;
    tick();
    const bool quiet = state.ringing < 0.1 * before;
    if (quiet && client.sounds() && client.amplitude(1, t_ns) > 0.6 * told) ++late;
  }
  CHECK(state.ringing < 1e-3 * before);
  CHECK(late <= 15);
}

}  // namespace
}  // namespace hapticd::test
