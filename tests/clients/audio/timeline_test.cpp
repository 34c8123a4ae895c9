// When orders are played, and what orders do to each other: frames are counted, nothing is timed.
#include "clients/audio/dsp/timeline.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "clients/audio/audio_engine.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/tone_measure.h"
#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/within.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;
constexpr FrameClock kFromZero{0, 0, 1e9 / kRate_hz};

std::int64_t ns_of_frame(std::int64_t frame) {
  return std::llround(static_cast<double>(frame) * 1e9 / kRate_hz);
}

Order strike_at(std::int64_t due_ns, int string = 0, double frequency_hz = 98.0) {
  Order order;
  order.due_ns = due_ns;
  ToneSound tone = test::tone_of(frequency_hz);
  tone.string = string;
  tone.decay_s = 0.5;
  order.strike = design_string(tone, test::bare()).value();
  return order;
}

Order damp_at(std::int64_t due_ns, double decay_s, int string = 0) {
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kChange;
  order.change.string = string;
  order.change.keep = keep_per_frame(decay_s, kRate_hz);
  return order;
}

/// The string goes to other partials, and a fifth up.
Order tell_at(std::int64_t due_ns, int string = 0, double frequency_hz = 98.0) {
  const std::array<float, 4> partials{0.1F, 1.0F, 0.0F, 0.4F};
  ToneSound tone = test::tone_of(frequency_hz);
  tone.string = string;
  tone.partials = partials;
  tone.amplitude_m = 1e-3;
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kTelling;
  order.strike = design_string(tone, test::bare()).value();
  order.telling.bend = {std::log(1.5 * frequency_hz), 29, {1e-4, 200}};
  order.telling.begins = true;
  return order;
}

/// The orders through an engine without a body, in blocks of the sizes that `next_size` gives.
template <typename NextSize>
std::vector<float> rendered(const std::vector<Order>& orders, std::size_t frames,
                            const NextSize& next_size) {
  const auto engine = std::make_unique<AudioEngine>(BodyFilter{});
  for (const Order& order : orders) REQUIRE(engine->submit(order));
  std::vector<float> sound(frames);
  MidiEvents notes;
  for (std::size_t done = 0; done < frames;) {
    const std::size_t size = std::min<std::size_t>(next_size(), frames - done);
    engine->render(kFromZero, static_cast<std::int64_t>(done), std::span(sound).subspan(done, size),
                   notes);
    done += size;
  }
  return sound;
}

std::vector<float> rendered(const std::vector<Order>& orders, std::size_t frames) {
  return rendered(orders, frames, [] { return std::size_t{128}; });
}

/// The first frame that is not silent.
std::int64_t onset(const std::vector<float>& sound) {
  std::int64_t frame = 0;
  while (static_cast<std::size_t>(frame) < sound.size() &&
         sound[static_cast<std::size_t>(frame)] == 0.0F)
    ++frame;
  return frame;
}

}  // namespace

TEST_CASE("a tone begins with the frame nearest to its instant") {
  // The first frame of a string is its position of rest.
  for (const std::int64_t frame : {1, 127, 128, 129, 1000, 4095}) {
    CHECK_EQ(onset(rendered({strike_at(ns_of_frame(frame))}, 8192)), frame + 1);
    CHECK_EQ(onset(rendered({strike_at(ns_of_frame(frame) + 10'000)}, 8192)), frame + 1);
    CHECK_EQ(onset(rendered({strike_at(ns_of_frame(frame) + 11'000)}, 8192)), frame + 2);
    CHECK_EQ(onset(rendered({strike_at(ns_of_frame(frame) - 10'000)}, 8192)), frame + 1);
  }
}

TEST_CASE("the same orders give the same bits in blocks of any size") {
  test::SplitMix64 random(7);
  std::vector<Order> orders;
  for (int i = 0; i < 40; ++i) {
    const auto at = static_cast<std::int64_t>(random.below(900'000'000));
    const int string = static_cast<int>(random.below(7));
    orders.push_back(strike_at(at, string, 65.4 + 12.0 * string));
    orders.back().strike.glide = {0.04, 0.9995};
    orders.push_back(damp_at(at + 50'000'000, 0.03, string));
    orders.push_back(tell_at(at + 70'000'123, string, 65.4 + 12.0 * string));
    orders.push_back(tell_at(at + 75'000'000, string, 70.0 + 12.0 * string));
  }
  const auto whole = rendered(orders, 48000, [] { return std::size_t{48000}; });
  for (const std::size_t size : {1U, 64U, 128U, 333U}) {
    CHECK(rendered(orders, 48000, [=] { return size; }) == whole);
  }
  CHECK(rendered(orders, 48000, [&] { return 1 + random.below(700); }) == whole);
}

TEST_CASE("an order whose instant is over is played at once and counted, none is dropped") {
  const auto timeline = std::make_unique<Timeline>(BodyFilter{});
  MidiEvents notes;
  std::vector<float> sound(128);
  timeline->render(kFromZero, 0, sound, notes);
  timeline->add(strike_at(ns_of_frame(100)));
  timeline->add(strike_at(ns_of_frame(200), 1));
  timeline->render(kFromZero, 128, sound, notes);
  CHECK_EQ(onset(sound), 1);
  CHECK_EQ(timeline->counts().played, 2);
  CHECK_EQ(timeline->counts().late, 1);
  CHECK(static_cast<double>(timeline->counts().latest_ns) == test::within(28e9 / kRate_hz, 1e-6));
}

TEST_CASE("orders are played by their instants, whatever order they come in") {
  test::SplitMix64 random(11);
  const auto timeline = std::make_unique<Timeline>(BodyFilter{});
  std::vector<std::int64_t> frames;
  for (int i = 0; i < 250; ++i) {
    frames.push_back(static_cast<std::int64_t>(random.below(20000)));
    timeline->add(strike_at(ns_of_frame(frames.back()), i));
  }
  std::sort(frames.begin(), frames.end());
  std::vector<std::int64_t> begun;
  std::vector<float> sound(100);
  MidiEvents notes;
  for (std::int64_t first = 0; first < 20000; first += 100) {
    timeline->render(kFromZero, first, sound, notes);
    while (begun.size() < timeline->counts().played) begun.push_back(first);
  }
  REQUIRE_EQ(begun.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) CHECK_EQ(begun[i], frames[i] / 100 * 100);
  CHECK_EQ(timeline->counts().late, 0);
}

TEST_CASE("more orders than can wait stay in the ring, and none is lost") {
  const auto engine = std::make_unique<AudioEngine>(BodyFilter{});
  int taken = 0;
  for (int i = 0; i < 1000; ++i)
    taken += engine->submit(strike_at(ns_of_frame(std::int64_t{50} * i), i)) ? 1 : 0;
  CHECK_EQ(taken, 1000);
  std::vector<float> sound(128);
  MidiEvents notes;
  for (std::int64_t first = 0; first < 52000; first += 128) {
    engine->render(kFromZero, first, sound, notes);
  }
  CHECK_EQ(engine->counts().played, 1000);
  CHECK_EQ(engine->counts().late, 0);
}

TEST_CASE("a finger damps a string with the decay it was told, and leaving it lets it ring again") {
  const std::int64_t touch = 24000;
  const std::int64_t leave = 26400;
  Order free = damp_at(ns_of_frame(leave), 1.0);
  free.change.keep = 1.0;
  const auto alone = rendered({strike_at(0)}, 48000);
  const auto damped = rendered({strike_at(0), damp_at(ns_of_frame(touch), 0.03), free}, 48000);
  for (std::size_t i = 0; i < 48000; i += 7) {
    const double touched_s =
        static_cast<double>(std::clamp<std::int64_t>(static_cast<std::int64_t>(i), touch, leave) -
                            touch) /
        kRate_hz;
    const double expected = static_cast<double>(alone[i]) * std::exp(-touched_s / 0.03);
    CHECK(static_cast<double>(damped[i]) == doctest::Approx(expected).epsilon(1e-5).scale(1e-3));
  }
  const auto other = rendered({strike_at(0), damp_at(ns_of_frame(touch), 0.03, 1)}, 48000);
  CHECK(other == alone);
}

TEST_CASE("a string plucked anew has one tone: the old one is gone within 20 ms") {
  const auto both = rendered({strike_at(0), strike_at(ns_of_frame(24000))}, 48000);
  const auto second = rendered({strike_at(ns_of_frame(24000))}, 48000);
  for (std::size_t i = 24000 + 960; i < 48000; ++i) {
    CHECK(std::abs(both[i] - second[i]) < 6e-4F);
  }
}

TEST_CASE("strings sound together: the sum of each alone") {
  std::vector<Order> orders;
  std::vector<double> sum(24000);
  for (int string = 0; string < 20; ++string) {
    orders.push_back(
        strike_at(ns_of_frame(std::int64_t{100} * string), string, 65.0 + 9.0 * string));
    const auto alone = rendered({orders.back()}, sum.size());
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(alone[i]);
  }
  const auto together = rendered(orders, sum.size());
  for (std::size_t i = 0; i < sum.size(); i += 11) {
    CHECK(static_cast<double>(together[i]) == doctest::Approx(sum[i]).epsilon(1e-5).scale(1e-3));
  }
}

TEST_CASE("more tones than voices end the ones that have decayed furthest, and count them") {
  const auto timeline = std::make_unique<Timeline>(BodyFilter{});
  for (int i = 0; i < 40; ++i) timeline->add(strike_at(ns_of_frame(std::int64_t{200} * i), i));
  std::vector<float> sound(9000);
  MidiEvents notes;
  timeline->render(kFromZero, 0, sound, notes);
  CHECK_EQ(timeline->counts().played, 40);
  CHECK_EQ(timeline->counts().stolen, 40 - kVoices);
  CHECK_EQ(timeline->synthesizer().sounding(), kVoices);
}

TEST_CASE("notes follow the tones: on with them, off when damped, plucked anew or died away") {
  const auto timeline = std::make_unique<Timeline>(BodyFilter{});
  std::vector<float> sound(1000);
  MidiEvents notes;
  const auto render = [&](std::int64_t first) { timeline->render(kFromZero, first, sound, notes); };
  timeline->add(strike_at(ns_of_frame(10), 3, 440.0));
  render(0);
  REQUIRE_EQ(notes.count, 1);
  CHECK_EQ(notes.events[0].frame, 10);
  CHECK(notes.events[0].bytes == std::array<std::uint8_t, 3>{0x93, 69, 64});
  timeline->add(strike_at(ns_of_frame(1500), 3, 220.0));
  render(1000);
  REQUIRE_EQ(notes.count, 2);
  CHECK(notes.events[0].bytes == std::array<std::uint8_t, 3>{0x83, 69, 0});
  CHECK(notes.events[1].bytes == std::array<std::uint8_t, 3>{0x93, 57, 64});
  CHECK_EQ(notes.events[1].frame, 500);
  timeline->add(damp_at(ns_of_frame(2001), 0.03, 3));
  render(2000);
  REQUIRE_EQ(notes.count, 1);
  CHECK(notes.events[0].bytes == std::array<std::uint8_t, 3>{0x83, 57, 0});
  timeline->add(strike_at(ns_of_frame(3000), 3, 220.0));
  std::int64_t ended = 0;
  for (std::int64_t first = 3000; first < 480000; first += 1000) {
    render(first);
    if (first > 3000 && notes.count == 1) ended = first;
  }
  CHECK_EQ(ended, (3000 + 336000 - 1) / 1000 * 1000);
}

TEST_CASE(
    "a string that is told to sound begins a note, and one that is told to be silent ends it") {
  const auto timeline = std::make_unique<Timeline>(BodyFilter{});
  std::vector<float> sound(1000);
  MidiEvents notes;
  timeline->add(tell_at(ns_of_frame(10), 3, 220.0));
  timeline->add(tell_at(ns_of_frame(500), 3, 220.0));
  timeline->render(kFromZero, 0, sound, notes);
  REQUIRE_EQ(notes.count, 1);
  CHECK_EQ(notes.events[0].bytes[0], 0x93);
  CHECK_EQ(notes.events[0].frame, 10);
  CHECK_EQ(timeline->synthesizer().sounding(), 1);
  Order silent = tell_at(ns_of_frame(1100), 3, 220.0);
  silent.strike.partials = {};
  silent.telling.ends_note = true;
  timeline->add(silent);
  timeline->render(kFromZero, 1000, sound, notes);
  REQUIRE_EQ(notes.count, 1);
  CHECK_EQ(notes.events[0].bytes[0], 0x83);
  CHECK_EQ(timeline->synthesizer().sounding(), 0);
}

TEST_CASE("the audio callback neither allocates nor frees, whatever is ordered") {
  const auto engine = std::make_unique<AudioEngine>(test::whole().body);
  std::vector<float> samples(48000, 0.1F);
  std::vector<Order> orders;
  for (int i = 0; i < 200; ++i) {
    orders.push_back(strike_at(ns_of_frame(std::int64_t{90} * i), i % 50, 70.0 + i));
    if (i % 3 == 0) orders.back().strike.recorded = {samples.data(), 48000, 1.01};
    if (i % 4 == 0) orders.back().strike.glide = {0.05, 0.999};
    orders.push_back(damp_at(ns_of_frame(std::int64_t{90} * i + 40), 0.01, i % 50));
    orders.push_back(tell_at(ns_of_frame(std::int64_t{90} * i + 60), i % 50, 70.0 + i));
  }
  std::vector<float> sound(128);
  MidiEvents notes;
  std::size_t next = 0;
  std::int64_t touched = 0;
  for (std::int64_t first = 0; first < 24000; first += 128) {
    while (next < orders.size() && orders[next].due_ns < ns_of_frame(first + 256)) {
      REQUIRE(engine->submit(orders[next++]));
    }
    const test::NoHeapScope scope;
    engine->render(kFromZero, first, sound, notes);
    touched += scope.count();
  }
  CHECK_EQ(touched, 0);
  CHECK_EQ(engine->counts().played, 200);
}

}  // namespace hapticd::audio
