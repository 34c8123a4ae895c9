// Exactly once, in order, both ways, whatever the network does: real server, real clients, virtual
// clock. PROTOCOL.md, sections 3 and 4.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "tests/clients/library/virtual_network.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// A network as bad as it may get: up to 60 % loss, 25 % twice, 50 ms out of order.
LinkConditions bad_conditions(SplitMix64& random) {
  LinkConditions conditions;
  conditions.loss = random.chance(0.2) ? 0.0 : random.uniform(0.0, 0.6);
  conditions.duplication = random.uniform(0.0, 0.25);
  conditions.delay_ns = static_cast<std::int64_t>(random.below(5'000'000));
  conditions.jitter_ns =
      random.chance(0.3) ? 0 : static_cast<std::int64_t>(random.below(50'000'000));
  return conditions;
}

std::vector<std::uint32_t> up_to(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

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
  if (network.asked.size() != count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (network.asked[i].item.get_parameters().paths(0) != std::to_string(i)) return false;
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
  }
}

}  // namespace
}  // namespace hapticd::test
