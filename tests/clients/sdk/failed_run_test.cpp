// Runs that are refused, cut short or answered with nonsense: what cannot be is refused before
// anything runs, and what a run produced until it failed can still be read. And what a C caller
// does not read has an end. Truth: what the server on loopback played.
#include <doctest/doctest.h>
#include <hapticd/client/session.h>
#include <hapticd_client.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/clients/library/real_server.h"

using namespace hapticd;
using namespace hapticd::test;

namespace {

std::string address_of(const RealServer& server) {
  return "127.0.0.1:" + std::to_string(server.port());
}

client::Session acquired(const RealServer& server) {
  client::SessionOptions options;
  options.server = address_of(server);
  client::Session session(options);
  session.acquire("test");
  return session;
}

/// The code of the Error that a run ends with; none: it succeeded.
std::optional<v1::ResultCode> code_of_run(client::Session& session, std::uint64_t steps,
                                          const std::vector<client::Pose>& poses = {}) {
  try {
    (void)session.run(steps, poses);
  } catch (const client::Error& error) {
    CHECK(std::string(error.what()).size() > 10);
    return error.code();
  }
  return std::nullopt;
}

using CSession = std::unique_ptr<hapticd_session, void (*)(hapticd_session*)>;

CSession opened(const RealServer& server) {
  const std::string address = address_of(server);
  const hapticd_options options{sizeof options, 0, address.c_str(), nullptr};
  hapticd_session* session = nullptr;
  REQUIRE(hapticd_open(&options, &session) == HAPTICD_OK);
  REQUIRE(hapticd_acquire(session, "test") == HAPTICD_OK);
  return {session, hapticd_close};
}

std::vector<std::uint64_t> unread_ticks(hapticd_session* session) {
  std::vector<std::uint64_t> ticks;
  hapticd_state state{};
  state.size = sizeof state;
  while (hapticd_next_state(session, &state) == 1) ticks.push_back(state.tick);
  return ticks;
}

/// Instants of the tones, and what the last event says was dropped.
struct UnreadTones {
  std::vector<std::uint64_t> t_ns;
  std::uint64_t dropped = 0;
};

UnreadTones unread_tones(hapticd_session* session) {
  UnreadTones unread;
  hapticd_event event{};
  event.size = sizeof event;
  while (hapticd_next_event(session, &event) == 1) {
    if (event.kind == HAPTICD_EVENT_TONE) unread.t_ns.push_back(event.t_ns);
    unread.dropped = event.dropped;
  }
  return unread;
}

}  // namespace

TEST_CASE("a run of no steps or too many sends no pose and runs nothing") {
  RealServer server;
  client::Session session = acquired(server);
  const std::vector<client::Pose> path(3000);
  for (const std::uint64_t steps : {0ULL, 1'000'000'001ULL, ~0ULL}) {
    CHECK(code_of_run(session, steps, path) == v1::RESULT_CODE_OUT_OF_RANGE);
  }
  CHECK(server.poses == 0);
  CHECK(server.ticks == 0);
}

TEST_CASE("a run whose poses the daemon refuses does not run") {
  RealServer server;
  server.refuse_poses = true;
  client::Session session = acquired(server);
  CHECK(code_of_run(session, 100, std::vector<client::Pose>(50)) == v1::RESULT_CODE_NOT_FOUND);
  CHECK(server.ticks == 0);
  server.refuse_poses = false;
  CHECK(session.run(10, std::vector<client::Pose>(10)).steps == 10);
  CHECK(server.ticks == 10);
}

TEST_CASE("what a run played before it failed can be read") {
  RealServer server;
  server.tones = true;
  server.bye_at_tick = 1000;
  client::Session session = acquired(server);
  session.subscribe(1);
  CHECK(code_of_run(session, 100'000) == v1::RESULT_CODE_UNSPECIFIED);
  // 64 States and 256 Items are under way at most.
  std::uint64_t tick = 0;
  for (; const std::optional<v1::State> state = session.next_state(); ++tick) {
    REQUIRE(state->tick() == tick);
  }
  CHECK(tick >= 900);
  std::uint64_t tones = 0;
  while (const std::optional<v1::Item> event = session.next_event()) {
    if (!event->has_tone()) continue;
    REQUIRE(event->tone().t_ns() == 1'000'000 * tones);
    ++tones;
  }
  CHECK(tones >= 700);
}

TEST_CASE("in C, too, what a run played before it failed can be read") {
  RealServer server;
  server.tones = true;
  server.bye_at_tick = 1000;
  const CSession session = opened(server);
  REQUIRE(hapticd_subscribe(session.get(), 1) == HAPTICD_OK);
  CHECK(hapticd_run(session.get(), 100, nullptr, 0, nullptr) == HAPTICD_OK);
  CHECK(hapticd_run(session.get(), 100'000, nullptr, 0, nullptr) == HAPTICD_SILENT);
  const std::vector<std::uint64_t> ticks = unread_ticks(session.get());
  REQUIRE(ticks.size() >= 900);
  for (std::size_t k = 0; k < ticks.size(); ++k) REQUIRE(ticks[k] == k);
  CHECK(unread_tones(session.get()).t_ns.size() >= 700);
}

TEST_CASE("an answer that claims more ticks than were asked for is an error") {
  RealServer server;
  client::Session session = acquired(server);
  session.subscribe(1);
  server.said_steps = 1'000'000'000'000;
  server.said_next_tick = 2'000'000'000'000;
  CHECK(code_of_run(session, 10) == v1::RESULT_CODE_FAILED);
  CHECK(session.next_state().has_value());
  server.said_steps = 0;
  server.said_next_tick = 5;
  CHECK(code_of_run(session, 10) == v1::RESULT_CODE_FAILED);
}

TEST_CASE("ticks near the end of their range are told, and found missing, as others are") {
  RealServer server;
  client::Session session = acquired(server);
  session.subscribe(7);
  server.said_next_tick = ~0ULL;
  // 2^64 = 2 mod 7: of the ten ticks before 2^64 - 1 the multiples of 7 are 2^64 - 9 and - 2.
  CHECK(session.run(10).missing == std::vector<std::uint64_t>{~0ULL - 8, ~0ULL - 1});
  session.subscribe(1'000'000);
  CHECK(session.run(10).missing.empty());
}

TEST_CASE("a session that would keep nothing is refused") {
  RealServer server;
  for (const bool states : {true, false}) {
    client::SessionOptions options;
    options.server = address_of(server);
    (states ? options.keep_states : options.keep_events) = 0;
    CHECK_THROWS_AS(client::Session{options}, std::invalid_argument);
  }
}

TEST_CASE("a C caller that never reads keeps the last run, and no more than the limits before it") {
  RealServer server;
  const CSession session = opened(server);
  REQUIRE(hapticd_subscribe(session.get(), 1) == HAPTICD_OK);
  for (int k = 0; k < 20; ++k) {
    REQUIRE(hapticd_run(session.get(), 1000, nullptr, 0, nullptr) == HAPTICD_OK);
  }
  const std::vector<std::uint64_t> ticks = unread_ticks(session.get());
  CHECK(ticks.size() == 16384);
  CHECK(ticks.back() == 19'999);
  REQUIRE(hapticd_run(session.get(), 10, nullptr, 0, nullptr) == HAPTICD_OK);
  REQUIRE(hapticd_run(session.get(), 20'000, nullptr, 0, nullptr) == HAPTICD_OK);
  CHECK(unread_ticks(session.get()).size() == 20'000);
}

TEST_CASE("events of runs that a C caller never reads make room, and are counted") {
  RealServer server;
  server.tones = true;
  const CSession session = opened(server);
  for (int k = 0; k < 7; ++k) {
    REQUIRE(hapticd_run(session.get(), 10'000, nullptr, 0, nullptr) == HAPTICD_OK);
  }
  const UnreadTones unread = unread_tones(session.get());
  CHECK(unread.t_ns.size() == 65536);
  CHECK(unread.t_ns.back() == 69'999'000'000);
  CHECK(unread.dropped >= 70'000 - 65536);
}
