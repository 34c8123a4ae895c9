// States and events as the structs of C. Truth: the messages they are made from.
#include "clients/sdk/c_structs.h"

#include <doctest/doctest.h>

#include <cstring>
#include <string>

using namespace hapticd;

TEST_CASE("strings and tools that are not told do not look like the first one") {
  v1::State state;
  state.set_strings_total(3);
  state.add_strings()->set_string_index(0);
  state.add_tools()->set_tool_id(0);
  const hapticd_state made = client::c_state(state);
  CHECK(made.string_count == 3);
  CHECK(made.strings[0].string_index == 0);
  for (int k = 1; k < HAPTICD_MOST_STRINGS; ++k) CHECK(made.strings[k].string_index == -1);
  CHECK(made.tools[0].tool_id == 0);
  for (int k = 1; k < HAPTICD_MOST_TOOLS; ++k) CHECK(made.tools[k].tool_id == -1);
}

TEST_CASE("an event without a tool has none") {
  v1::Item item;
  item.mutable_fault()->set_cause(v1::CAUSE_DEVICE_LOST);
  CHECK(client::c_event(item).tool_id == -1);
  item.mutable_fault()->set_tool_id(0);
  CHECK(client::c_event(item).tool_id == 0);
  item.mutable_contact();
  CHECK(client::c_event(item).tool_id == 0);
  item.mutable_scene_info();
  CHECK(client::c_event(item).tool_id == -1);
}

TEST_CASE("a message that is too long ends with a whole character") {
  v1::Item item;
  const auto told = [&](const std::string& message) {
    item.mutable_fault()->set_message(message);
    return std::string(client::c_event(item).message);
  };
  CHECK(told(std::string(256, 'a')) == std::string(256, 'a'));
  CHECK(told(std::string(300, 'a')) == std::string(256, 'a'));
  CHECK(told(std::string(254, 'a') + "\u00fc") == std::string(254, 'a') + "\u00fc");
  CHECK(told(std::string(255, 'a') + "\u00fc") == std::string(255, 'a'));
  CHECK(told(std::string(253, 'a') + "\U0001F3B5\u00fc") == std::string(253, 'a'));
}
