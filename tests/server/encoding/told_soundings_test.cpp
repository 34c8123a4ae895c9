// What States repeat for those who come late, against the events as they were told.
#include "server/encoding/told_soundings.h"

#include <doctest/doctest.h>

#include <google/protobuf/util/message_differencer.h>

namespace hapticd::test {
namespace {

constexpr std::uint32_t kScene = 4;

v1::Item sounding(std::uint32_t string, std::uint32_t number, float amplitude_m) {
  v1::Item item;
  v1::StringSounding& sounding = *item.mutable_string_sounding();
  sounding.set_string_index(string);
  sounding.set_number(number);
  sounding.set_t_ns(1'000'000'000ULL + number);
  sounding.set_cause(v1::SOUNDING_CAUSE_ONSET);
  sounding.set_lambda_from(0.25F);
  sounding.set_lambda_to(1.0F);
  sounding.set_frequency_hz(98.5F);
  sounding.set_cents_per_s(-30.0F);
  sounding.set_inharmonicity(1e-4F);
  sounding.set_tool_id(3);
  if (!(amplitude_m > 0.0F)) return item;
  for (const float phase : {0.1F, -2.0F}) {
    sounding.add_partials_m(amplitude_m);
    sounding.add_decays_s(1.5F);
    sounding.add_phases_rad(phase);
  }
  return item;
}

/// A State of the scene in which these strings are listed.
v1::State state_with(std::initializer_list<std::uint32_t> strings, std::uint32_t scene = kScene) {
  v1::State state;
  state.set_scene_id(scene);
  for (const std::uint32_t string : strings) {
    state.add_strings()->set_string_index(string);
  }
  return state;
}

}  // namespace

TEST_CASE("a State repeats the newest message of each string to the bit, but for its phases") {
  ToldSoundings told;
  told.take(kScene, sounding(7, 1, 2e-3F));
  told.take(kScene, sounding(2, 4, 1e-3F));
  told.take(kScene, sounding(7, 2, 1.5e-3F));
  v1::State state = state_with({2, 5, 7});
  told.add_to(0, state);
  CHECK_FALSE(state.strings(1).has_sounding());
  v1::StringSounding newest = sounding(7, 2, 1.5e-3F).string_sounding();
  newest.clear_phases_rad();
  CHECK(google::protobuf::util::MessageDifferencer::Equals(state.strings(2).sounding(), newest));
  CHECK(state.strings(0).sounding().number() == 4);
  CHECK(state.strings(0).sounding().phases_rad().empty());
}

TEST_CASE("what has fallen silent is not repeated, and what sounds again is") {
  ToldSoundings told;
  told.take(kScene, sounding(7, 1, 2e-3F));
  told.take(kScene, sounding(7, 2, 0.0F));
  v1::State silent = state_with({7});
  told.add_to(0, silent);
  CHECK_FALSE(silent.strings(0).has_sounding());
  told.take(kScene, sounding(7, 3, 1e-3F));
  v1::State again = state_with({7});
  told.add_to(0, again);
  CHECK(again.strings(0).sounding().number() == 3);
}

TEST_CASE("strings before the first that is asked for are left out") {
  ToldSoundings told;
  for (const std::uint32_t string : {0U, 1U, 2U}) told.take(kScene, sounding(string, 1, 1e-3F));
  v1::State state = state_with({0, 1, 2});
  told.add_to(1, state);
  CHECK_FALSE(state.strings(0).has_sounding());
  CHECK(state.strings(1).has_sounding());
  CHECK(state.strings(2).has_sounding());
}

TEST_CASE("of one scene nothing is told in another, whichever comes first, States or events") {
  ToldSoundings told;
  told.take(kScene, sounding(7, 9, 1e-3F));
  v1::State next = state_with({7}, kScene + 1);
  told.add_to(0, next);
  CHECK_FALSE(next.strings(0).has_sounding());
  told.take(kScene + 1, sounding(3, 1, 1e-3F));
  v1::State last = state_with({7});
  told.add_to(0, last);
  CHECK_FALSE(last.strings(0).has_sounding());
  told.add_to(0, next);
  CHECK_FALSE(next.strings(0).has_sounding());
}

TEST_CASE("other events change nothing") {
  ToldSoundings told;
  told.take(kScene, sounding(7, 9, 1e-3F));
  v1::Item tone;
  tone.mutable_tone()->set_string_index(7);
  told.take(kScene + 1, tone);
  v1::State state = state_with({7});
  told.add_to(0, state);
  CHECK(state.strings(0).sounding().number() == 9);
}

}  // namespace hapticd::test
