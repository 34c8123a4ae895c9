// A player that comes while strings ring: what States repeat is begun as it sounds by then, once,
// and what has been heard already is left alone.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "clients/audio/event_player.h"
#include "tests/clients/audio/played.h"
#include "tests/clients/audio/tone_measure.h"
#include "tests/support/within.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;
constexpr std::uint64_t kTold_ns = 7'000'000'000;

/// A player whose orders are kept.
struct Kept {
  std::vector<Order> orders;
  EventPlayer player{test::bare(), nullptr, [this](const Order& order) {
                       orders.push_back(order);
                       return true;
                     }};
};

/// String 2, as it was told at kTold_ns.
v1::StringSounding told(std::uint32_t number) {
  v1::StringSounding sounding;
  sounding.set_string_index(2);
  sounding.set_number(number);
  sounding.set_t_ns(kTold_ns);
  sounding.set_frequency_hz(146.8F);
  sounding.add_partials_m(2e-3F);
  sounding.add_decays_s(1.5F);
  return sounding;
}

v1::State state_with(const v1::StringSounding& sounding, double since_s) {
  v1::State state;
  state.set_t_ns(kTold_ns + static_cast<std::uint64_t>(since_s * 1e9));
  state.add_strings()->set_string_index(0);
  v1::StringState& string = *state.add_strings();
  string.set_string_index(2);
  *string.mutable_sounding() = sounding;
  return state;
}

v1::Item event_of(const v1::StringSounding& sounding) {
  v1::Item item;
  *item.mutable_string_sounding() = sounding;
  return item;
}

/// What is heard of a string whose message is `since_s` old when the player comes.
std::vector<float> joined(const v1::StringSounding& sounding, double since_s) {
  Kept kept;
  kept.player.join(state_with(sounding, since_s), 99);
  REQUIRE(kept.orders.size() == 1);
  CHECK(kept.orders[0].due_ns == 99);
  REQUIRE(kept.orders[0].kind == Order::Kind::kTelling);
  CHECK(kept.orders[0].telling.begins);
  CHECK(kept.orders[0].strike.string == 2);
  return test::played(kept.orders[0].strike, test::bare(), 0.6);
}

}  // namespace

TEST_CASE("a string that rang before is begun as loud as it is by then, at its pitch") {
  const std::vector<float> at_once = joined(told(5), 0.0);
  for (const double since : {0.02, 0.3, 2.0}) {
    CAPTURE(since);
    const std::vector<float> later = joined(told(5), since);
    const double louder = test::rms(at_once, kRate_hz, 0.1, 0.2);
    const double softer = test::rms(later, kRate_hz, 0.1, 0.2);
    CHECK(softer / louder == test::within(std::exp(-since / 1.5), 0.01));
    const double hz = test::frequency_near(later, kRate_hz, 146.8, 0.1, 0.2, 0.1);
    CHECK(std::abs(test::cents(hz, 146.8)) < 2.0);
  }
}

TEST_CASE("a pitch that glided when it was told is begun where it has come to, and stays") {
  v1::StringSounding gliding = told(5);
  gliding.set_cents_per_s(-400.0F);
  for (const double since : {0.05, 0.1, 1.0}) {
    CAPTURE(since);
    const double wanted = 146.8 * std::exp2(-400.0 * std::min(since, 0.1) / 1200.0);
    const double hz = test::frequency_near(joined(gliding, since), kRate_hz, wanted, 0.1, 0.2, 0.1);
    CHECK(std::abs(test::cents(hz, wanted)) < 2.0);
  }
}

TEST_CASE("partials that decay faster have faded more: a string is begun with what is left") {
  v1::StringSounding bright = told(5);
  bright.add_partials_m(2e-3F);
  bright.add_decays_s(0.1F);
  // After a second the second partial is 87 dB below where it was, the first 6 dB.
  const std::vector<float> sound = joined(bright, 1.0);
  const std::vector<float> pure = joined(told(5), 1.0);
  const double softer = test::rms(pure, kRate_hz, 0.1, 0.2);
  CHECK(test::rms(sound, kRate_hz, 0.1, 0.2) / softer == test::within(1.0, 0.01));
  // Had it kept as much of the second, it would be heard, and 3 dB more of both.
  v1::StringSounding even = bright;
  even.set_decays_s(1, 1.5F);
  CHECK(test::rms(joined(even, 1.0), kRate_hz, 0.1, 0.2) > 1.1 * softer);
}

TEST_CASE("what events have told already a State does not begin again, nor the other way round") {
  Kept kept;
  kept.player.play(event_of(told(5)), 10);
  REQUIRE(kept.orders.size() == 1);
  kept.player.join(state_with(told(5), 0.1), 20);
  kept.player.join(state_with(told(4), 0.1), 30);
  CHECK(kept.orders.size() == 1);
  Kept late;
  late.player.join(state_with(told(5), 0.1), 20);
  late.player.join(state_with(told(5), 0.2), 30);
  late.player.play(event_of(told(5)), 40);
  REQUIRE(late.orders.size() == 1);
  CHECK(late.orders[0].due_ns == 20);
  // Who has begun follows what is told next, by a State too.
  late.player.join(state_with(told(6), 0.3), 50);
  REQUIRE(late.orders.size() == 2);
  CHECK(late.orders[1].kind == Order::Kind::kTelling);
  CHECK(late.orders[1].due_ns == 50);
}

TEST_CASE("what was told of the strings of one scene says nothing in the next") {
  Kept kept;
  kept.player.join(state_with(told(5), 0.1), 10);
  kept.player.set_scene({});
  kept.player.join(state_with(told(1), 0.1), 20);
  CHECK(kept.orders.size() == 2);
}

TEST_CASE("States without sounds, or with such as no string can have, begin nothing") {
  const auto begins = [](const v1::State& state) {
    Kept kept;
    kept.player.join(state, 0);
    return !kept.orders.empty();
  };
  REQUIRE(begins(state_with(told(5), 0.1)));
  v1::State silent = state_with(told(5), 0.0);
  silent.mutable_strings(1)->clear_sounding();
  CHECK_FALSE(begins(silent));
  CHECK_FALSE(begins({}));
  for (const float number : {std::nanf(""), -1.0F, 0.0F, std::numeric_limits<float>::infinity()}) {
    v1::StringSounding bad = told(5);
    bad.set_decays_s(0, number);
    CHECK_FALSE(begins(state_with(bad, 0.1)));
    bad = told(5);
    bad.set_partials_m(0, number);
    CHECK_FALSE(begins(state_with(bad, 0.1)));
    bad = told(5);
    bad.set_frequency_hz(number);
    CHECK_FALSE(begins(state_with(bad, 0.1)));
  }
  v1::StringSounding other = told(5);
  other.set_string_index(3);
  CHECK_FALSE(begins(state_with(other, 0.1)));
  v1::State beyond = state_with(told(5), 0.1);
  beyond.mutable_strings(1)->set_string_index(4'000'000'000U);
  beyond.mutable_strings(1)->mutable_sounding()->set_string_index(4'000'000'000U);
  CHECK_FALSE(begins(beyond));
}

}  // namespace hapticd::audio
