// Exactly once, in order, both ways, whatever the network does: real server, real clients, virtual
// clock. PROTOCOL.md, sections 3 and 4.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tests/clients/library/virtual_network.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Requests one client sent, and the Results it got, in order.
struct Requests {
  std::vector<std::uint64_t> sent_ids;
  std::vector<std::uint64_t> answered_ids;

  void send(VirtualClient& from) {
    const std::uint64_t number = sent_ids.size();
    sent_ids.push_back(from.core->request(numbered_request(number), [this](const v1::Result* r) {
      if (r != nullptr) answered_ids.push_back(r->item_id());
    }));
  }
};

bool asked_in_order(const VirtualNetwork& network, std::size_t count) {
  if (network.host.asked.size() != count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (network.host.asked[i].item.get_parameters().paths(0) != std::to_string(i)) return false;
  }
  return true;
}

TEST_CASE("Items arrive exactly once and in order, both ways, whatever the network does") {
  const std::int64_t schedules = scaled(10'000);
  SplitMix64 random(2026);
  for (std::int64_t schedule = 0; schedule < schedules; ++schedule) {
    CAPTURE(schedule);
    VirtualNetwork network;
    VirtualClient& mine = network.add_client(bad_conditions(random), random.next());
    mine.clock_skew = random.uniform(-200e-6, 200e-6);
    mine.clock_offset_ns = static_cast<std::int64_t>(random.below(1'000'000'000'000));
    // The greeting first: events before a session begins are not for it.
    REQUIRE(network.run_until(8 * kTestSecond_ns, [&] { return mine.core->heard(); }));
    Requests requests;
    const std::size_t events = 1 + random.below(60);
    const std::size_t asks = 1 + random.below(60);
    std::size_t told = 0;
    network.tick_each_step = random.chance(0.3);
    if (network.tick_each_step) {
      v1::Item subscribe;
      subscribe.mutable_subscribe()->set_divisor(1);
      mine.core->request(subscribe);
    }
    const auto done = [&] {
      return told == events && mine.tones().size() >= events &&
             requests.answered_ids.size() >= asks;
    };
    const double pace = random.uniform(0.02, 1.0);
    REQUIRE(network.run_until(30 * kTestSecond_ns, [&] {
      if (told < events && random.chance(pace)) {
        network.server->broadcast(tone_item(static_cast<std::uint32_t>(told++)));
      }
      if (requests.sent_ids.size() < asks && random.chance(pace)) requests.send(mine);
      return done();
    }));
    network.run_for(100 * kTestMillisecond_ns);  // Late duplicates.
    CHECK(mine.tones() == up_to(events));
    CHECK(asked_in_order(network, asks));
    CHECK(requests.answered_ids == requests.sent_ids);
    CHECK(mine.ends.empty());
    CHECK(network.server->counters().protocol_errors == 0);
    if (!mine.core->clock().known()) continue;  // Its first exchanges were lost.
    const std::int64_t own_ns = mine.own_ns(network.now_ns);
    const wire::ClockRelation relation = mine.core->clock().at(own_ns);
    CHECK(std::abs(relation.offset_ns - (network.now_ns - own_ns)) <= relation.uncertainty_ns);
  }
}

// The last server was asked nothing twice, and each session's requests in order: a datagram that
// had long been under way to the server before may have opened a session of its own.
void check_asked_once(const VirtualNetwork& network) {
  std::set<std::uint64_t> all;
  std::map<std::uint64_t, std::uint64_t> newest;
  for (const RecordingHost::Asked& each : network.host.asked) {
    const std::uint64_t asked = std::stoull(each.item.get_parameters().paths(0));
    CHECK(all.insert(asked).second);
    CHECK((newest.count(each.id.session) == 0 || newest[each.id.session] < asked));
    newest[each.id.session] = asked;
  }
}

/// Answers are in order, each once, and from number `before` on none is missing.
void check_answers(const std::vector<std::uint64_t>& answered, std::size_t before,
                   std::uint64_t first_new) {
  for (std::size_t i = 0; i < 5; ++i) CHECK(answered[before + i] == first_new + i);
  CHECK(std::is_sorted(answered.begin(), answered.end()));
  CHECK(std::adjacent_find(answered.begin(), answered.end()) == answered.end());
}

/// Tones of the first server have numbers below 1000 and come without a gap.
template <typename Tones>
void check_first_server_in_order(const Tones& tones) {
  for (std::size_t i = 1; i < tones.size() && tones[i] < 1000; ++i) {
    CHECK(tones[i] == tones[i - 1] + 1);
  }
}

TEST_CASE("a restart of the server loses requests, but repeats and reorders none") {
  const std::int64_t schedules = scaled(2000);
  SplitMix64 random(77);
  for (std::int64_t schedule = 0; schedule < schedules; ++schedule) {
    CAPTURE(schedule);
    VirtualNetwork network;
    VirtualClient& mine = network.add_client(bad_conditions(random), random.next());
    std::size_t told = 0;
    int lost = 0;
    std::vector<std::uint64_t> answered;
    std::uint64_t number = 0;
    const auto traffic = [&] {
      if (random.chance(0.1)) {
        network.server->broadcast(tone_item(static_cast<std::uint32_t>(told++)));
      }
      if (!random.chance(0.1)) return;
      const std::uint64_t mine_number = number++;
      mine.core->request(numbered_request(mine_number), [&, mine_number](const v1::Result* r) {
        if (r == nullptr) {
          ++lost;
        } else {
          answered.push_back(mine_number);
        }
      });
    };
    for (std::uint32_t boot = 2; boot < 5; ++boot) {
      for (std::uint64_t steps = random.below(600); steps > 0; --steps) {
        traffic();
        network.step();
      }
      network.start_server({.boot_id = boot});
    }
    // The last server is reached, and everything sent to it arrives.
    REQUIRE(network.run_until(60 * kTestSecond_ns, [&] {
      return mine.core->boot_id() == 4 && mine.core->heard() &&
             answered.size() + static_cast<std::size_t>(lost) == number;
    }));
    network.run_for(3 * kTestSecond_ns);
    const std::size_t before = answered.size();
    const std::uint64_t first_new = number;
    std::size_t first_tone = mine.tones().size();
    for (int i = 0; i < 5; ++i)
      network.server->broadcast(tone_item(1000U + static_cast<unsigned>(i)));
    for (int i = 0; i < 5; ++i) {
      const std::uint64_t mine_number = number++;
      mine.core->request(numbered_request(mine_number), [&, mine_number](const v1::Result* r) {
        if (r != nullptr) answered.push_back(mine_number);
      });
    }
    REQUIRE(network.run_until(30 * kTestSecond_ns, [&] {
      return answered.size() == before + 5 && mine.tones().size() >= first_tone + 5;
    }));
    check_answers(answered, before, first_new);
    check_asked_once(network);
    check_first_server_in_order(mine.tones());
  }
}

TEST_CASE("a scene of many Chunks arrives whole over a bad network, both ways") {
  const std::int64_t schedules = scaled(300);
  SplitMix64 random(5);
  for (std::int64_t schedule = 0; schedule < schedules; ++schedule) {
    CAPTURE(schedule);
    VirtualNetwork network;
    std::string text;
    for (int i = 0; text.size() < 2000 + random.below(20'000); ++i) text += std::to_string(i) + " ";
    network.host.greeting[0].mutable_scene_info()->set_server_version(text);
    VirtualClient& mine = network.add_client(bad_conditions(random), random.next());
    v1::Item acquire;
    acquire.mutable_acquire();
    mine.core->request(acquire);
    v1::Item load;
    load.mutable_load_scene()->set_text(text);
    bool answered = false;
    mine.core->request(load, [&](const v1::Result* r) { answered = r != nullptr; });
    REQUIRE(network.run_until(100 * kTestSecond_ns,
                              [&] { return answered && mine.items.size() >= 3; }));
    REQUIRE(network.host.asked.size() == 1);
    CHECK(network.host.asked[0].item.load_scene().text() == text);
    CHECK(mine.items[0].scene_info().server_version() == text);
  }
}

}  // namespace
}  // namespace hapticd::test
