// Who comes late learns what sounds, from States: when they repeat it, and how it is shared out
// where not all of it has room. PROTOCOL.md, section 6.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "server/network/state_fitting.h"
#include "tests/server/network/raw_peer.h"

namespace hapticd::test {
namespace {

/// As many strings as `strings`, all of them sounding, each with what a daemon may say of it at
/// most; and a patch with `contacts` contacts.
auto sounding_fill(std::uint32_t strings, int contacts = 0) {
  return [=](const Subscription& subscription, v1::State& state) {
    for (std::uint32_t i = 0; i < strings; ++i) {
      v1::StringState& string = *state.add_strings();
      string.set_string_index(i);
      string.set_radius_m(0.001F);
      if (!subscription.soundings_from || i < *subscription.soundings_from) continue;
      v1::StringSounding& sounding = *string.mutable_sounding();
      sounding.set_number(100 + i);
      sounding.set_string_index(i);
      sounding.set_t_ns(std::uint64_t{1} << 50U);
      for (int k = 0; k < 12; ++k) sounding.add_partials_m(1e-3F);
      for (int k = 0; k < 12; ++k) sounding.add_decays_s(1.0F);
    }
    if (contacts == 0) return;
    v1::ContactPatch& patch = *state.add_contacts();
    for (int i = 0; i < contacts; ++i) {
      patch.add_tool_sphere(i);
      patch.add_gap_nanometres(i);
      patch.add_force_mn(1000);
      for (int k = 0; k < 3; ++k) patch.add_p_wc_um(100'000 + k);
      for (int k = 0; k < 3; ++k) patch.add_nhat_og_w_e4(5773);
    }
  };
}

/// Ticks of the States in which string `index` has its sounding.
std::vector<std::uint64_t> told_in(const RawPeer& peer, std::uint32_t index) {
  std::vector<std::uint64_t> ticks;
  for (const v1::State& state : peer.states()) {
    for (const v1::StringState& string : state.strings()) {
      if (string.string_index() != index || !string.has_sounding()) continue;
      CHECK(string.sounding().number() == 100 + index);
      ticks.push_back(state.tick());
    }
  }
  return ticks;
}

using Ticks = std::vector<std::uint64_t>;

}  // namespace

TEST_CASE("the first State of a subscription says what sounds, and then one in 100 ms") {
  ServerBench bench;
  bench.host.fill = sounding_fill(2);
  RawPeer early(bench, 5);
  RawPeer late(bench, 6, 40'001);
  early.send(subscribe_item(1));
  for (std::uint64_t tick = 0; tick < 130; ++tick) bench.offer(tick);
  late.send(subscribe_item(7));
  for (std::uint64_t tick = 130; tick < 420; ++tick) bench.offer(tick);
  CHECK(told_in(early, 1) == Ticks{0, 100, 200, 300, 400});
  // Multiples of 7: the first after tick 130, then the first of each 100 ms.
  CHECK(told_in(late, 0) == Ticks{133, 203, 301, 406});
  late.send(subscribe_item(1));
  for (std::uint64_t tick = 420; tick < 440; ++tick) bench.offer(tick);
  CHECK(told_in(late, 0) == Ticks{133, 203, 301, 406, 420});
}

TEST_CASE("100 ms are those of the stream, whatever the period of a tick is") {
  ServerBench bench({.boot_id = 9, .period_ns = 250'000});
  bench.host.fill = sounding_fill(1);
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(1));
  for (std::uint64_t tick = 10; tick < 900; ++tick) bench.offer(tick);
  CHECK(told_in(peer, 0) == Ticks{10, 400, 800});
}

TEST_CASE("a new scene begins a new round") {
  ServerBench bench;
  bench.host.fill = sounding_fill(1);
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(1));
  for (std::uint64_t tick = 40; tick < 60; ++tick) bench.offer(tick, 1);
  for (std::uint64_t tick = 0; tick < 20; ++tick) bench.offer(tick, 2);
  CHECK(told_in(peer, 0) == Ticks{40, 0});
}

TEST_CASE("without the strings nothing of them is told") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Item item = subscribe_item(1);
  item.mutable_subscribe()->add_sections(v1::SECTION_TOOLS);
  peer.send(item);
  bench.offer(0);
  REQUIRE(bench.host.subscriptions.size() == 1);
  CHECK_FALSE(bench.host.subscriptions[0].soundings_from.has_value());
}

TEST_CASE("what has no room follows in the next States, every string in each round") {
  ServerBench bench;
  bench.host.fill = sounding_fill(25);
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(1));
  for (std::uint64_t tick = 0; tick < 250; ++tick) {
    bench.offer(tick);
    if (tick % 50 == 0) peer.pass(50);
  }
  for (const v1::State& state : peer.states()) CHECK(state.strings_size() == 25);
  for (std::uint32_t i = 0; i < 25; ++i) {
    const Ticks told = told_in(peer, i);
    CAPTURE(i);
    REQUIRE(told.size() == 3);
    // 25 soundings of about 130 bytes, into at least 400 bytes of each State.
    for (std::size_t round = 0; round < 3; ++round) {
      CHECK(told[round] >= 100 * round);
      CHECK(told[round] < 100 * round + 10);
    }
  }
}

TEST_CASE("a round that takes longer than 100 ms ends before the next begins") {
  ServerBench bench;
  bench.host.fill = sounding_fill(25);
  RawPeer peer(bench, 5);
  peer.send(subscribe_item(100));
  for (std::uint64_t tick = 0; tick < 1500; tick += 100) {
    bench.offer(tick);
    peer.pass(50);
  }
  for (std::uint32_t i = 0; i < 25; ++i) {
    CAPTURE(i);
    CHECK_FALSE(told_in(peer, i).empty());
  }
}

TEST_CASE("contacts make way for one string that sounds and for no more") {
  const auto with = [](std::uint32_t strings, std::optional<std::uint32_t> from) {
    v1::State state;
    sounding_fill(strings, 256)({.divisor = 1, .soundings_from = from}, state);
    return state;
  };
  const v1::State whole = with(5, 0);
  const std::vector<v1::State> parts = fit_state(whole, 1000, {});
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].ByteSizeLong() <= 1000);
  CHECK(parts[0].strings_size() == 5);
  CHECK(parts[0].contacts_total() == 256);
  for (int i = 0; i < 5; ++i) CHECK(parts[0].strings(i).has_sounding() == (i == 0));
  CHECK(soundings_left(whole, parts[0]) == std::optional<std::uint32_t>(1));
  // The contacts that are left are as many as fit.
  const int kept = parts[0].contacts(0).force_mn_size();
  v1::State more = parts[0];
  v1::ContactPatch& patch = *more.mutable_contacts(0);
  patch.add_tool_sphere(kept);
  patch.add_gap_nanometres(kept);
  patch.add_force_mn(1000);
  for (int k = 0; k < 3; ++k) patch.add_p_wc_um(100'000 + k);
  for (int k = 0; k < 3; ++k) patch.add_nhat_og_w_e4(5773);
  CHECK(more.ByteSizeLong() > 1000);
}

TEST_CASE("where all has room nothing is left, and a string that was left out is not waited for") {
  v1::State whole;
  sounding_fill(4)({.divisor = 1, .soundings_from = 0}, whole);
  CHECK_FALSE(soundings_left(whole, whole).has_value());
  v1::State none = whole;
  none.clear_strings();
  CHECK(soundings_left(whole, none) == std::optional<std::uint32_t>(1));
  v1::State only;
  sounding_fill(4)({.divisor = 1, .soundings_from = 3}, only);
  CHECK_FALSE(soundings_left(only, none).has_value());
}

}  // namespace hapticd::test
