// The C++ interface of libhapticd-client against a server on loopback: what a run collects, what a
// caller reads late, and the tables that come of it.
#include <doctest/doctest.h>
#include <hapticd/client/session.h>
#include <hapticd/client/table.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "clients/sdk/assignment.h"
#include "tests/clients/library/real_server.h"
#include "tests/support/german_locale.h"
#include "tests/support/skip.h"

using namespace hapticd;
using namespace hapticd::test;

namespace {

client::SessionOptions at(const RealServer& server) {
  client::SessionOptions options;
  options.server = "127.0.0.1:" + std::to_string(server.port());
  return options;
}

std::vector<std::uint64_t> ticks_of(const std::vector<v1::State>& states) {
  std::vector<std::uint64_t> ticks;
  ticks.reserve(states.size());
  for (const v1::State& state : states) ticks.push_back(state.tick());
  return ticks;
}

std::vector<std::uint64_t> multiples(std::uint64_t begin, std::uint64_t end, std::uint64_t step) {
  std::vector<std::uint64_t> ticks;
  for (std::uint64_t tick = begin; tick < end; tick += step) ticks.push_back(tick);
  return ticks;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

TEST_CASE("a run has the States of its ticks, all of them and no others") {
  RealServer server;
  client::Session session(at(server));
  session.acquire("test");
  session.subscribe(1);
  CHECK(ticks_of(session.run(1000).states) == multiples(0, 1000, 1));
  session.subscribe(7);
  const client::RunResult result = session.run(2500);
  CHECK(ticks_of(result.states) == multiples(1001, 3500, 7));
  CHECK(result.missing.empty());
  CHECK(result.next_tick == 3500);
  CHECK_FALSE(session.next_state().has_value());
  session.subscribe(0);
  CHECK(session.run(10).states.empty());
}

TEST_CASE("a path longer than the daemon's queue is run to its end, and a longer one no further") {
  RealServer server;
  client::Session session(at(server));
  session.acquire("test");
  const std::vector<client::Pose> path(5000);
  CHECK(session.run(5000, path).steps == 5000);
  CHECK(server.poses == 5000);
  CHECK(session.run(30, path).steps == 30);
  CHECK(server.poses == 5030);
}

TEST_CASE("what is not read makes room, oldest first, and is counted") {
  RealServer server;
  client::SessionOptions options = at(server);
  options.keep_events = 2;
  client::Session session(options);
  session.acquire("test");
  // SceneInfo, LeaseInfo and RecordInfo greet a session, and acquire() adds a LeaseInfo.
  const client::Unread unread = session.poll(std::chrono::nanoseconds(0));
  CHECK(unread.events == 2);
  CHECK(unread.dropped_events >= 1);
  while (const auto event = session.next_event()) CHECK_FALSE(event->has_scene_info());
}

TEST_CASE("a daemon that is not there is named in the error") {
  client::SessionOptions options;
  options.server = "127.0.0.1:1";
  options.timeout = std::chrono::milliseconds(50);
  try {
    const client::Session session(options);
    FAIL("it opened");
  } catch (const client::Error& error) {
    CHECK(error.code() == v1::RESULT_CODE_UNSPECIFIED);
    CHECK(std::string(error.what()).find("127.0.0.1:1") != std::string::npos);
  }
}

TEST_CASE("an address that is none is refused at once, and says what is one") {
  for (const std::string bad : {"x:y", "127.0.0.1:99999", "127.0.0.1:0"}) {
    client::SessionOptions options;
    options.server = bad;
    try {
      const client::Session session(options);
      FAIL("it opened");
    } catch (const std::invalid_argument& error) {
      CHECK(std::string(error.what()).find("'" + bad + "'") != std::string::npos);
      CHECK(std::string(error.what()).find("HOST:PORT") != std::string::npos);
    }
  }
}

TEST_CASE("a program compiled with other messages is told to be built anew") {
  RealServer server;
  CHECK_NOTHROW(client::Session(at(server), client::kMessages));
  try {
    const client::Session session(at(server), client::kMessages ^ 1U);
    FAIL("it opened");
  } catch (const client::Error& error) {
    CHECK(error.code() == v1::RESULT_CODE_UNSUPPORTED);
    CHECK(std::string(error.what()).find("Build it anew") != std::string::npos);
  }
}

TEST_CASE("values go to the wire and come back as they were") {
  const auto kept = [](const client::Value& value) {
    CHECK(client::value_of(client::assignment("path", value)).data == value.data);
  };
  kept(0.1);
  kept(7);
  kept(true);
  kept("45 N");
  kept(std::vector<double>{1.0, 2.0, 3.0});
  CHECK(client::Value(7).number() == 7.0);
  CHECK(client::Value(true).data == client::Value(true).data);
  CHECK(std::holds_alternative<bool>(client::Value(true).data));
  CHECK(client::assignment("path", 7).has_number());
}

TEST_CASE("a table of States has decimal points where the locale has commas") {
  const GermanLocale german;
  if (!german.in_force()) return skip("no German locale can be made: " + german.said());
  std::vector<v1::State> states(1);
  states[0].add_tools()->add_p_wh_m(0.25);
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "sdk_german.csv";
  client::write_states(states, file.string());
  const std::string text = text_of(file);
  std::filesystem::remove(file);
  CHECK(text.find("\n0,0,0,0,0,0.25,") != std::string::npos);
}

TEST_CASE("a table of States keeps every bit and leaves room for tools that are missing") {
  std::vector<v1::State> states(2);
  states[0].set_tick(4);
  states[0].set_t_ns(4'000'000);
  for (int k = 0; k < 2; ++k) {
    v1::ToolState& tool = *states[0].add_tools();
    tool.set_tool_id(static_cast<std::uint32_t>(k));
    for (const double x : {0.1, 1.0 / 3.0, -2.5e-7}) tool.add_p_wh_m(x);
  }
  states[1].set_tick(5);
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "sdk_states.csv";
  client::write_states(states, file.string());
  const std::string text = text_of(file);
  std::filesystem::remove(file);
  CHECK(text.starts_with("tick,t_ns,loop_state,cause,tool0_id,tool0_wh_x_m,"));
  CHECK(text.find(",tool1_minimum_gap_m\n4,4000000,0,0,0,0.10000000000000001,"
                  "0.33333333333333331,-2.4999999999999999e-07,") != std::string::npos);
  const std::string last = text.substr(text.find("\n5,") + 1);
  const std::string first = text.substr(0, text.find('\n'));
  CHECK(std::count(last.begin(), last.end(), ',') == std::count(first.begin(), first.end(), ','));
  CHECK_THROWS_AS(client::write_states({}, file.string()), std::runtime_error);
  CHECK_THROWS_AS(client::write_states(states, "/dev/null/file.csv"), std::runtime_error);
}
