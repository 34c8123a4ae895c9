// When tones are heard, in virtual time: scripted clocks, arrivals of packets and wake-ups of the
// sound card, through the clock estimate and the audio engine. The onset is looked for in the sound
// itself and held against the event's own instant + D.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "clients/audio/audio_engine.h"
#include "clients/audio/event_player.h"
#include "clients/audio/live.h"
#include "proto/wire/clock_estimate.h"
#include "tests/support/random.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;

/// A machine, a network and a sound card.
struct Script {
  double offset_s = 1234.5;  ///< server's clock minus own clock at the beginning
  double skew = 50e-6;       ///< its growth
  double exchange_s = 1e-3;  ///< a way of a clock exchange takes at most, at least a tenth
  double way_s = 1e-3;       ///< a packet's, likewise
  double loss = 0.0;         ///< of packets; repeated after 1, 3, 7, 15, 31 ms
  int block = 128;           ///< frames
  int latency = 256;         ///< from a block's wake-up to the ear, frames
  double wake_s = 0.3e-3;    ///< how late the callback may run
  double delay_s = 8e-3;     ///< D
  int tones = 500;
};

struct Heard {
  double rms_s = 0.0;    ///< of onset minus (event + D)
  double worst_s = 0.0;  ///< the largest
  std::uint64_t late = 0;
  std::uint64_t expected_late = 0;
  std::uint64_t played = 0;
  std::size_t onsets = 0;
};

struct Event {
  double happens_s;  ///< own clock
  double arrives_s;
};

double arrival(double sent_s, const Script& script, test::SplitMix64& random) {
  constexpr double kRepeats_s[] = {0.0, 1e-3, 3e-3, 7e-3, 15e-3, 31e-3};
  const double way_s = random.uniform(0.1, 1.0) * script.way_s;
  for (const double repeat_s : kRepeats_s) {
    if (!random.chance(script.loss)) return sent_s + repeat_s + way_s;
  }
  return sent_s + 0.08 + way_s;
}

std::vector<Event> events_of(const Script& script, test::SplitMix64& random) {
  std::vector<Event> events;
  double at_s = 10.0;
  for (int i = 0; i < script.tones; ++i) {
    at_s += random.uniform(0.15, 0.25);
    events.push_back({at_s, arrival(at_s, script, random)});
  }
  return events;
}

v1::Item tone_item(std::uint64_t t_ns) {
  v1::Item item;
  v1::Tone& tone = *item.mutable_tone();
  tone.set_t_ns(t_ns);
  tone.set_frequency_hz(440.0F);
  tone.set_level(1.0F);
  tone.set_lambda(0.2F);
  tone.set_decay_s(0.005F);
  return item;
}

/// One run of a script.
class Run {
 public:
  Run(const Script& script, std::uint64_t seed)
      : script_(script),
        random_(seed),
        events_(events_of(script, random_)),
        frames_(static_cast<std::size_t>(script.block)) {}

  Heard heard() {
    const double end_s = events_.back().happens_s + 1.0;
    MidiEvents notes;
    for (std::int64_t frame = 0; static_cast<double>(frame) / kRate_hz < end_s;
         frame += script_.block) {
      const double cycle_s = static_cast<double>(frame) / kRate_hz;
      const double wakes_s = cycle_s + random_.uniform() * script_.wake_s;
      const double heard_s = cycle_s + script_.latency / kRate_hz;
      exchange_clocks(wakes_s);
      receive(wakes_s, heard_s);
      engine_->render({frame, std::llround(heard_s * 1e9), 1e9 / kRate_hz}, frame, frames_, notes);
      listen(heard_s);
    }
    heard_.rms_s = std::sqrt(sum_ / static_cast<double>(heard_.onsets));
    heard_.late = engine_->counts().late;
    heard_.played = engine_->counts().played;
    return heard_;
  }

 private:
  [[nodiscard]] std::int64_t server_ns(double own_s) const {
    return std::llround((own_s * (1.0 + script_.skew) + script_.offset_s) * 1e9);
  }

  /// Twice a second.
  void exchange_clocks(double until_s) {
    for (; exchange_s_ < until_s; exchange_s_ += 0.5) {
      const double there_s = random_.uniform(0.1, 1.0) * script_.exchange_s;
      const double back_s = random_.uniform(0.1, 1.0) * script_.exchange_s;
      const std::int64_t met_ns = server_ns(exchange_s_ + there_s);
      const std::int64_t sent_ns = std::llround(exchange_s_ * 1e9);
      const std::int64_t back_ns = std::llround((exchange_s_ + there_s + back_s) * 1e9);
      const std::int64_t middle_ns = (sent_ns + back_ns) / 2;
      clock_.add({middle_ns, met_ns - middle_ns, back_ns - sent_ns});
    }
  }

  /// What has arrived when the callback wakes for the block that is heard at heard_s.
  void receive(double wakes_s, double heard_s) {
    for (; next_ < events_.size() && events_[next_].arrives_s <= wakes_s; ++next_) {
      const auto t_ns = static_cast<std::uint64_t>(server_ns(events_[next_].happens_s));
      const std::int64_t now_ns = std::llround(events_[next_].arrives_s * 1e9);
      const std::int64_t due =
          due_ns(t_ns, clock_, true, now_ns, std::llround(script_.delay_s * 1e9));
      player_.play(tone_item(t_ns), due);
      // By the clock as it is estimated, late means: the block that is woken for begins after it.
      if (static_cast<double>(due) * 1e-9 < heard_s - 0.5 / kRate_hz) ++heard_.expected_late;
    }
  }

  /// Looks for onsets in the block.
  void listen(double heard_s) {
    for (int i = 0; i < script_.block; ++i) {
      if (frames_[static_cast<std::size_t>(i)] == 0.0F) {
        ++silent_frames_;
        continue;
      }
      if (silent_frames_ > 500 && heard_.onsets < events_.size()) {
        const double onset_s = heard_s + i / kRate_hz;
        const double error_s = onset_s - (events_[heard_.onsets].happens_s + script_.delay_s);
        sum_ += error_s * error_s;
        heard_.worst_s = std::max(heard_.worst_s, std::abs(error_s));
        ++heard_.onsets;
      }
      silent_frames_ = 0;
    }
  }

  const Script& script_;
  test::SplitMix64 random_;
  std::vector<Event> events_;
  std::vector<float> frames_;
  wire::ClockEstimate clock_;
  std::unique_ptr<AudioEngine> engine_ = std::make_unique<AudioEngine>(BodyFilter{});
  EventPlayer player_{
      {kRate_hz, 1.0, {}}, nullptr, [this](const Order& order) { return engine_->submit(order); }};
  Heard heard_;
  double exchange_s_ = 0.1;
  std::size_t next_ = 0;
  int silent_frames_ = 1000;
  double sum_ = 0.0;
};

Heard run(const Script& script, std::uint64_t seed) { return Run(script, seed).heard(); }

void check(const Heard& heard, const Script& script, double rms_s) {
  MESSAGE("rms " << heard.rms_s * 1e3 << " ms, worst " << heard.worst_s * 1e3 << " ms, late "
                 << heard.late << " of " << heard.played);
  CHECK_EQ(heard.played, static_cast<std::uint64_t>(script.tones));
  CHECK_EQ(heard.onsets, static_cast<std::size_t>(script.tones));
  CHECK_EQ(heard.late, heard.expected_late);
  CHECK(heard.rms_s <= rms_s);
}

}  // namespace

TEST_CASE("tones are heard at t_ns + D within 0.3 ms where D leaves time for the sound card") {
  Script script;
  script.delay_s = 12e-3;
  const Heard heard = run(script, 1);
  check(heard, script, 0.3e-3);
  CHECK_EQ(heard.late, 0);
}

TEST_CASE("with the default delay and blocks of 64, likewise") {
  Script script;
  script.block = 64;
  script.latency = 128;
  const Heard heard = run(script, 2);
  check(heard, script, 0.3e-3);
  CHECK_EQ(heard.late, 0);
}

TEST_CASE("with the default delay and blocks of 128 the schedule errs by 1 ms rms at most") {
  const Script script;
  check(run(script, 3), script, 1e-3);
}

TEST_CASE("clocks that drift by 200 ppm and a jittering network do not move the tones") {
  for (const double skew : {-200e-6, 200e-6}) {
    Script script;
    script.skew = skew;
    script.exchange_s = 3e-3;
    script.delay_s = 14e-3;
    check(run(script, 4), script, 1e-3);
  }
}

TEST_CASE(
    "a network that loses every fifth packet loses no tone, and the schedule errs by 1 ms rms") {
  Script script;
  script.loss = 0.2;
  script.delay_s = 12e-3;
  const Heard heard = run(script, 5);
  check(heard, script, 1e-3);
  CHECK(heard.late > 0);
  CHECK(heard.late < 30);
}

TEST_CASE(
    "before the clocks are known, and under a virtual clock, a tone is heard D after it came") {
  wire::ClockEstimate unknown;
  CHECK_EQ(due_ns(5, unknown, true, 1'000, 8'000), 9'000);
  wire::ClockEstimate known;
  known.add({.at_ns = 900, .offset_ns = 500, .round_trip_ns = 10});
  CHECK_EQ(due_ns(1'450, known, true, 1'000, 8'000), 8'950);
  CHECK_EQ(due_ns(1'450, known, false, 1'000, 8'000), 9'000);
  CHECK_EQ(due_ns(UINT64_MAX, known, true, 1'000, 8'000), 9'000);
}

}  // namespace hapticd::audio
