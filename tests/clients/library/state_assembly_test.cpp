// Newest wins, parts become one State, each tick once. PROTOCOL.md, section 6.
#include "clients/library/state_assembly.h"

#include <doctest/doctest.h>

namespace hapticd::client {
namespace {

v1::State state_of(std::uint64_t tick, std::uint32_t scene_id = 1) {
  v1::State state;
  state.set_tick(tick);
  state.set_scene_id(scene_id);
  return state;
}

v1::State part_of(std::uint64_t tick, std::uint32_t index, std::uint32_t count) {
  v1::State state = state_of(tick);
  state.set_part_index(index);
  state.set_part_count(count);
  state.add_tools()->set_tool_id(index);
  return state;
}

TEST_CASE("a State is given out once, an older one never") {
  StateAssembly states;
  CHECK(states.take(state_of(5), true).has_value());
  CHECK(!states.take(state_of(5), true).has_value());
  CHECK(!states.take(state_of(4), false).has_value());
  CHECK(states.take(state_of(6), true).has_value());
  CHECK(states.seen() == 4);
  CHECK(states.newest() == 6);
}

TEST_CASE("a new scene begins at tick 0, and States of the one before are dropped") {
  StateAssembly states;
  CHECK(states.take(state_of(1000, 1), true).has_value());
  CHECK(states.take(state_of(0, 2), true).has_value());
  CHECK(states.newest() == 0);
  CHECK(!states.take(state_of(1001, 1), false).has_value());
  CHECK(states.newest() == 0);
  CHECK(states.seen() == 3);
}

TEST_CASE("parts of a tick become one State in any order") {
  StateAssembly states;
  CHECK(!states.take(part_of(3, 2, 3), true).has_value());
  CHECK(!states.take(part_of(3, 0, 3), false).has_value());
  CHECK(!states.take(part_of(3, 0, 3), false).has_value());
  const auto whole = states.take(part_of(3, 1, 3), false);
  REQUIRE(whole.has_value());
  CHECK(whole->tools_size() == 3);
  CHECK(whole->part_count() == 0);
  CHECK(!states.take(part_of(3, 1, 3), false).has_value());
}

TEST_CASE("a tick of which a part is lost gives way to the next") {
  StateAssembly states;
  CHECK(!states.take(part_of(3, 0, 2), true).has_value());
  CHECK(!states.take(part_of(4, 0, 2), true).has_value());
  CHECK(!states.take(part_of(3, 1, 2), false).has_value());
  CHECK(states.take(part_of(4, 1, 2), false).has_value());
}

TEST_CASE("parts that contradict the limits are dropped") {
  StateAssembly states;
  CHECK(!states.take(part_of(3, 32, 2), true).has_value());
  CHECK(!states.take(part_of(3, 0, 33), true).has_value());
  CHECK(!states.take(part_of(3, 2, 2), true).has_value());
  for (std::uint32_t i = 0; i < 31; ++i) CHECK(!states.take(part_of(3, i, 32), true).has_value());
  CHECK(states.take(part_of(3, 31, 32), true).has_value());
}

}  // namespace
}  // namespace hapticd::client
