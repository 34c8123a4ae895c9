// The daemon's events as orders: what is played and when, what a finger on a ringing string does,
// and what is refused.
#include "clients/audio/event_player.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "tests/clients/audio/played.h"

namespace hapticd::audio {
namespace {

constexpr double kRate_hz = 48000.0;

/// A player whose orders are kept.
struct Kept {
  std::vector<Order> orders;
  std::size_t room = 100;
  EventPlayer player{test::bare(), nullptr, [this](const Order& order) {
                       if (orders.size() >= room) return false;
                       orders.push_back(order);
                       return true;
                     }};
};

v1::Item tone(std::uint32_t string, float decay_s = 0.5F) {
  v1::Item item;
  item.mutable_tone()->set_string_index(string);
  item.mutable_tone()->set_frequency_hz(98.0F);
  item.mutable_tone()->set_level(0.5F);
  item.mutable_tone()->set_lambda(0.1F);
  item.mutable_tone()->set_decay_s(decay_s);
  return item;
}

v1::Item radius(std::uint32_t string, v1::StringRadiusPhase phase, float r_max_m, float decay_s) {
  v1::Item item;
  v1::StringRadius& radius = *item.mutable_string_radius();
  radius.set_string_index(string);
  radius.set_phase(phase);
  radius.set_r_max_m(r_max_m);
  radius.set_decay_s(decay_s);
  return item;
}

/// Decay time that an order adds to the tone's own, s; infinite when it rings freely.
double added_decay_s(const Order& order) { return -1.0 / (std::log(order.change.keep) * kRate_hz); }

}  // namespace

TEST_CASE("a Tone becomes a strike at its instant, with string, level and note") {
  Kept kept;
  kept.player.play(tone(3), 12345);
  REQUIRE_EQ(kept.orders.size(), 1);
  CHECK_EQ(kept.orders[0].due_ns, 12345);
  CHECK(kept.orders[0].kind == Order::Kind::kStrike);
  CHECK_EQ(kept.orders[0].strike.string, 3);
  CHECK_EQ(kept.orders[0].strike.note.channel, 3);
  CHECK_EQ(kept.orders[0].strike.note.number, 43);  // G2
  CHECK_EQ(kept.orders[0].strike.note.velocity, 64);
}

TEST_CASE("a finger on a ringing string adds what is missing to the decay that the event names") {
  Kept kept;
  kept.player.play(tone(0), 0);
  kept.player.play(radius(0, v1::STRING_RADIUS_PHASE_DAMP, 1e-3F, 0.03F), 1000);
  REQUIRE_EQ(kept.orders.size(), 2);
  CHECK(kept.orders[1].kind == Order::Kind::kChange);
  CHECK_EQ(kept.orders[1].due_ns, 1000);
  CHECK(added_decay_s(kept.orders[1]) == doctest::Approx(1.0 / (1.0 / 0.03 - 1.0 / 0.5)));
}

TEST_CASE("a finger that leaves, and a touch that does not damp, let the string ring freely") {
  Kept kept;
  kept.player.play(tone(0), 0);
  kept.player.play(radius(0, v1::STRING_RADIUS_PHASE_RELEASE, 1e-3F, 0.5F), 1000);
  kept.player.play(radius(0, v1::STRING_RADIUS_PHASE_DAMP, 1e-3F, 0.5F), 2000);
  REQUIRE_EQ(kept.orders.size(), 3);
  CHECK_EQ(kept.orders[1].change.keep, 1.0);
  CHECK_EQ(kept.orders[2].change.keep, 1.0);
}

TEST_CASE("a string pressed or made still while its tone rings on is damped all the same") {
  Kept kept;
  v1::Scene scene;
  scene.add_strings()->set_touch_decay_s(0.05);
  kept.player.set_scene(scene);
  kept.player.play(tone(0, 5.0F), 0);
  kept.player.play(radius(0, v1::STRING_RADIUS_PHASE_PRESS, 0.0F, 0.0F), 1000);
  kept.player.play(radius(0, v1::STRING_RADIUS_PHASE_RELEASE, 0.0F, 0.0F), 2000);
  REQUIRE_EQ(kept.orders.size(), 3);
  CHECK(added_decay_s(kept.orders[1]) == doctest::Approx(1.0 / (1.0 / 0.05 - 1.0 / 5.0)));
  CHECK(added_decay_s(kept.orders[2]) == doctest::Approx(1.0 / (1.0 / 0.03 - 1.0 / 5.0)));
}

TEST_CASE("a string that has not sounded is not damped, other events are left alone") {
  Kept kept;
  kept.player.play(radius(0, v1::STRING_RADIUS_PHASE_PRESS, 0.0F, 0.0F), 0);
  v1::Item contact;
  contact.mutable_contact();
  kept.player.play(contact, 0);
  kept.player.play({}, 0);
  CHECK(kept.orders.empty());
}

TEST_CASE("events that make no sense are counted, not played; so are those that find no room") {
  Kept kept;
  v1::Item bad = tone(0);
  bad.mutable_tone()->set_frequency_hz(std::nanf(""));
  kept.player.play(bad, 0);
  bad = tone(1);
  bad.mutable_tone()->set_decay_s(-1.0F);
  kept.player.play(bad, 0);
  bad = tone(4'000'000'000U);
  kept.player.play(bad, 0);
  bad = tone(1);
  for (int i = 0; i < 65; ++i) bad.mutable_tone()->add_partials(1.0F);
  kept.player.play(bad, 0);
  for (const float partial : {std::nanf(""), INFINITY, -3e38F, 1e-30F, 0.0F}) {
    bad = tone(1);
    bad.mutable_tone()->add_partials(partial);
    kept.player.play(bad, 0);
  }
  CHECK(kept.orders.empty());
  CHECK_EQ(kept.player.counts().tones, 8);
  CHECK_EQ(kept.player.counts().unplayable, 8);
  kept.room = 1;
  kept.player.play(tone(0), 0);
  kept.player.play(tone(0), 0);
  CHECK_EQ(kept.orders.size(), 1);
  CHECK_EQ(kept.player.counts().lost, 1);
}

TEST_CASE("the scene's inharmonicity reaches the string") {
  Kept kept;
  v1::Scene scene;
  scene.add_strings()->set_inharmonicity(1e-4);
  scene.add_strings();
  kept.player.set_scene(scene);
  kept.player.play(tone(0), 0);
  kept.player.play(tone(1), 0);
  REQUIRE_EQ(kept.orders.size(), 2);
  CHECK(kept.orders[0].strike.loop.dispersion < kept.orders[1].strike.loop.dispersion);
}

}  // namespace hapticd::audio
