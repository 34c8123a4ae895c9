// The queue of one viewer against what a list kept beside it says, and against protobuf's own
// parser.
#include "clients/web/gateway/viewer_queue.h"

#include <doctest/doctest.h>

#include <vector>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using web::ViewerQueue;

web::SharedBody numbered_state(std::uint64_t tick) {
  v1::State state;
  state.set_tick(tick);
  return web::state_body(state);
}

web::SharedBody numbered_item(std::uint64_t tick) {
  v1::Item item;
  item.mutable_fault()->set_tick(tick);
  return web::item_body(item);
}

std::vector<v1::PageEvent> all_of(ViewerQueue& queue) {
  std::vector<v1::PageEvent> events;
  while (const auto message = queue.take()) {
    REQUIRE(events.emplace_back().ParseFromString(*message));
  }
  return events;
}

TEST_CASE("of too many States the oldest go, and a gap in the sequence tells where") {
  ViewerQueue queue({.states = 3});
  for (std::uint64_t tick = 1; tick <= 5; ++tick) queue.add_state(numbered_state(tick));
  const auto events = all_of(queue);
  REQUIRE(events.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(events[i].state().tick() == 3 + i);
    CHECK(events[i].sequence() == 3 + i);
  }
  CHECK(queue.dropped_states() == 2);
}

TEST_CASE("an event between States stays where it was, however many States go") {
  ViewerQueue queue({.states = 2});
  queue.add_state(numbered_state(1));
  REQUIRE(queue.add(numbered_item(100)));
  for (std::uint64_t tick = 2; tick <= 9; ++tick) queue.add_state(numbered_state(tick));
  const auto events = all_of(queue);
  REQUIRE(events.size() == 3);
  CHECK(events[0].item().fault().tick() == 100);
  CHECK(events[0].sequence() == 2);
  CHECK(events[1].state().tick() == 8);
  CHECK(events[2].state().tick() == 9);
}

TEST_CASE("a viewer that holds as many events as it may is told apart, and nothing is dropped") {
  ViewerQueue queue({.kept = 2});
  CHECK(queue.add(numbered_item(1)));
  CHECK(queue.add(numbered_item(2)));
  CHECK_FALSE(queue.add(numbered_item(3)));
  const auto events = all_of(queue);
  REQUIRE(events.size() == 2);
  CHECK(events[1].item().fault().tick() == 2);
  CHECK(events[1].sequence() == 2);
}

TEST_CASE("one event may be longer than all together, and goes through alone") {
  v1::Item large;
  large.mutable_fault()->set_message(std::string(2000, 'x'));
  ViewerQueue queue({.kept_bytes = 1000});
  CHECK(queue.add(web::item_body(large)));
  CHECK_FALSE(queue.add(numbered_item(1)));
  CHECK(all_of(queue).size() == 1);
  CHECK(queue.add(numbered_item(1)));
}

TEST_CASE("whatever comes and goes, events arrive in order and once, and of States the newest") {
  SplitMix64 random(7);
  for (std::int64_t run = 0; run < scaled(2000); ++run) {
    ViewerQueue queue({.states = 4, .kept = 6});
    std::vector<std::uint64_t> sent;
    std::vector<std::uint64_t> received;
    std::uint64_t number = 0;
    std::uint64_t newest_sent = 0;
    std::uint64_t last_sequence = 0;
    std::uint64_t last_state = 0;
    std::uint64_t states_received = 0;
    std::uint64_t states_sent = 0;
    const auto take = [&] {
      const auto message = queue.take();
      if (!message.has_value()) return;
      v1::PageEvent event;
      REQUIRE(event.ParseFromString(*message));
      CHECK(event.sequence() > last_sequence);
      last_sequence = event.sequence();
      if (event.has_item()) received.push_back(event.item().fault().tick());
      if (!event.has_state()) return;
      CHECK(event.state().tick() > last_state);
      last_state = event.state().tick();
      ++states_received;
    };
    for (int step = 0; step < 60; ++step) {
      ++number;
      const std::uint64_t what = random.below(3);
      if (what == 0) {
        queue.add_state(numbered_state(number));
        newest_sent = number;
        ++states_sent;
      } else if (what == 1) {
        if (queue.add(numbered_item(number))) sent.push_back(number);
      } else {
        take();
      }
    }
    while (queue.size() > 0) take();
    CHECK(received == sent);
    CHECK(last_state == newest_sent);
    CHECK(states_received + queue.dropped_states() == states_sent);
  }
}

}  // namespace
}  // namespace hapticd::test
