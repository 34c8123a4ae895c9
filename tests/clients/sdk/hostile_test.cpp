// The C interface against callers that get everything wrong, and daemons that vanish: a code comes
// back, nothing is sent, nothing beyond an argument is read or written, and the session works on.
#include <doctest/doctest.h>
#include <hapticd_client.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/clients/library/real_server.h"

using namespace hapticd;
using namespace hapticd::test;

namespace {

constexpr std::uint32_t kTimeout_ms = 300;
constexpr hapticd_pose kPose{{0.0, 0.01, 0.0}, {1.0, 0.0, 0.0, 0.0}};

/// A session that ends with the block.
class Opened {
 public:
  explicit Opened(std::uint16_t port) {
    const std::string server = "127.0.0.1:" + std::to_string(port);
    hapticd_options options{sizeof options, kTimeout_ms, server.c_str(), nullptr};
    REQUIRE(hapticd_open(&options, &session_) == HAPTICD_OK);
  }
  ~Opened() { hapticd_close(session_); }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  operator hapticd_session*() const { return session_; }

 private:
  hapticd_session* session_ = nullptr;
};

/// Bytes without an end, before memory that may not be read.
class Endless {
 public:
  explicit Endless(std::size_t bytes) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    all_ = (bytes / page + 1) * page + page;
    void* memory = mmap(nullptr, all_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    REQUIRE(memory != MAP_FAILED);
    memory_ = static_cast<char*>(memory);
    text_ = memory_ + all_ - page - bytes;
    std::memset(text_, 'x', bytes);
    REQUIRE(mprotect(memory_ + all_ - page, page, PROT_NONE) == 0);
  }
  ~Endless() { munmap(memory_, all_); }
  Endless(const Endless&) = delete;
  Endless& operator=(const Endless&) = delete;
  [[nodiscard]] const char* text() const { return text_; }

 private:
  std::size_t all_ = 0;
  char* memory_ = nullptr;
  char* text_ = nullptr;
};

/// Every function that takes a session, with arguments that are otherwise good.
std::vector<int> all_codes(hapticd_session* session) {
  const double value = 1.0;
  double read = 0.0;
  std::size_t count = 0;
  hapticd_state state{};
  state.size = sizeof state;
  hapticd_event event{};
  event.size = sizeof event;
  return {hapticd_poll(session, 1),
          hapticd_acquire(session, "test"),
          hapticd_take_over(session, "test", "a test"),
          hapticd_load_scene(session, "single_string"),
          hapticd_set(session, "tools[0].force_gain", &value, 1),
          hapticd_get(session, "tools[0].force_gain", &read, 1, &count),
          hapticd_subscribe(session, 1),
          hapticd_run(session, 1, &kPose, 1, nullptr),
          hapticd_next_state(session, &state),
          hapticd_next_event(session, &event),
          hapticd_play_gesture(session, "press", 1),
          hapticd_order(session, HAPTICD_STOP)};
}

}  // namespace

TEST_CASE("the structs of C have the layout that programs were compiled with") {
  CHECK(sizeof(hapticd_options) == 24);
  CHECK(sizeof(hapticd_pose) == 56);
  CHECK(sizeof(hapticd_run_result) == 64);
  CHECK(sizeof(hapticd_tool) == 120);
  CHECK(sizeof(hapticd_string) == 32);
  CHECK(offsetof(hapticd_state, tools) == 40);
  CHECK(offsetof(hapticd_state, strings) == 1000);
  CHECK(sizeof(hapticd_state) == 2024);
  CHECK(offsetof(hapticd_event, frequency_hz) == 64);
  CHECK(offsetof(hapticd_event, message) == 124);
  CHECK(sizeof(hapticd_event) == 384);
}

TEST_CASE("no function takes a null session, and close lets it pass") {
  for (const int code : all_codes(nullptr)) CHECK(code == HAPTICD_INVALID);
  hapticd_close(nullptr);
  CHECK(hapticd_last_error(nullptr) != nullptr);
}

TEST_CASE("an open that fails leaves null, with which nothing happens") {
  std::array<int, 1> somewhere{};
  hapticd_options options{sizeof options, 50, "127.0.0.1:1", nullptr};
  const Endless endless(300);
  const std::array<const char*, 5> servers{"127.0.0.1:1", "nonsense:99999", "", endless.text(),
                                           "no.such.host.invalid:47800"};
  for (const char* server : servers) {
    options.server = server;
    auto* session = reinterpret_cast<hapticd_session*>(somewhere.data());
    const int code = hapticd_open(&options, &session);
    CHECK(code < 0);
    CHECK(session == nullptr);
    CHECK(std::strlen(hapticd_last_error(session)) > 10);
    for (const int each : all_codes(session)) CHECK(each == HAPTICD_INVALID);
    hapticd_close(session);
  }
  options.server = "127.0.0.1:1";
  options.key_file = "/nonexistent/control.key";
  hapticd_session* session = nullptr;
  CHECK(hapticd_open(&options, &session) == HAPTICD_FAILED);
  CHECK(std::string(hapticd_last_error(nullptr)).find("control.key") != std::string::npos);
  CHECK(hapticd_open(&options, nullptr) == HAPTICD_INVALID);
  for (const std::uint32_t size : {0U, 8U, 0xFFFFFFFFU}) {
    options.size = size;
    CHECK(hapticd_open(&options, &session) == HAPTICD_INVALID);
    CHECK(session == nullptr);
  }
}

TEST_CASE("poses that are no poses are refused before anything is sent") {
  RealServer server;
  const Opened session(server.port());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  std::vector<hapticd_pose> poses(20, kPose);
  const auto refused = [&](const hapticd_pose& bad) {
    poses[19] = bad;
    CHECK(hapticd_run(session, 20, poses.data(), poses.size(), nullptr) == HAPTICD_INVALID);
    CHECK(std::string(hapticd_last_error(session)).find("pose 19") != std::string::npos);
  };
  refused({{nan, 0, 0}, {1, 0, 0, 0}});
  refused({{0, 0, -inf}, {1, 0, 0, 0}});
  refused({{0, 0, 0}, {1, 0, nan, 0}});
  refused({{0, 0, 0}, {0, inf, 0, 0}});
  refused({{0, 0, 0}, {0, 0, 0, 0}});
  refused({{0, 0, 0}, {3, 0, 0, 0}});
  CHECK(hapticd_run(session, 20, nullptr, 1, nullptr) == HAPTICD_INVALID);
  CHECK(hapticd_run(session, 0, poses.data(), 1, nullptr) == HAPTICD_INVALID);
  CHECK(hapticd_run(session, 1'000'000'001, poses.data(), 1, nullptr) == HAPTICD_INVALID);
  CHECK(server.poses == 0);
  REQUIRE(hapticd_acquire(session, "test") == HAPTICD_OK);
  CHECK(hapticd_run(session, 10, poses.data(), 10, nullptr) == HAPTICD_OK);
  CHECK(server.poses == 10);
}

TEST_CASE("the lease is taken over with a reason, and a text that is none takes nothing") {
  RealServer server;
  const Opened first(server.port());
  const Opened second(server.port());
  REQUIRE(hapticd_acquire(first, "first") == HAPTICD_OK);
  CHECK(hapticd_acquire(second, "second") == HAPTICD_BUSY);
  CHECK(hapticd_take_over(second, "second", "") == HAPTICD_BUSY);
  const Endless reason(401);
  CHECK(hapticd_take_over(second, "second", nullptr) == HAPTICD_INVALID);
  CHECK(hapticd_take_over(second, "second", reason.text()) == HAPTICD_INVALID);
  CHECK(hapticd_run(first, 1, &kPose, 1, nullptr) == HAPTICD_OK);
  REQUIRE(hapticd_take_over(second, "second", "a test") == HAPTICD_OK);
  CHECK(hapticd_run(first, 1, &kPose, 1, nullptr) == HAPTICD_REFUSED);
  CHECK(hapticd_run(second, 1, &kPose, 1, nullptr) == HAPTICD_OK);
  // Back and forth: each grant has a number of its own, which its holder's requests carry.
  REQUIRE(hapticd_take_over(first, "first", "back") == HAPTICD_OK);
  CHECK(hapticd_run(first, 1, &kPose, 1, nullptr) == HAPTICD_OK);
}

TEST_CASE("texts and numbers that make no sense are refused, and no byte too many is read") {
  RealServer server;
  const Opened session(server.port());
  const Endless name(HAPTICD_MOST_NAME + 1);
  const Endless holder(65);
  const Endless scene(HAPTICD_MOST_SCENE + 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> many(1025, 1.0);
  double value = 1.0;
  std::size_t count = 0;
  CHECK(hapticd_acquire(session, holder.text()) == HAPTICD_INVALID);
  CHECK(hapticd_acquire(session, nullptr) == HAPTICD_INVALID);
  CHECK(hapticd_load_scene(session, scene.text()) == HAPTICD_INVALID);
  CHECK(hapticd_load_scene(session, nullptr) == HAPTICD_INVALID);
  CHECK(hapticd_play_gesture(session, scene.text(), 1) == HAPTICD_INVALID);
  CHECK(hapticd_play_gesture(session, "tracks {", 1) == HAPTICD_INVALID);
  CHECK(hapticd_set(session, name.text(), &value, 1) == HAPTICD_INVALID);
  CHECK(hapticd_set(session, nullptr, &value, 1) == HAPTICD_INVALID);
  CHECK(hapticd_set(session, "path", nullptr, 1) == HAPTICD_INVALID);
  CHECK(hapticd_set(session, "path", &value, 0) == HAPTICD_INVALID);
  CHECK(hapticd_set(session, "path", many.data(), many.size()) == HAPTICD_INVALID);
  CHECK(hapticd_set(session, "path", &nan, 1) == HAPTICD_INVALID);
  CHECK(hapticd_get(session, name.text(), &value, 1, &count) == HAPTICD_INVALID);
  CHECK(hapticd_get(session, "path", nullptr, 1, &count) == HAPTICD_INVALID);
  CHECK(hapticd_get(session, "path", &value, 1, nullptr) == HAPTICD_INVALID);
  CHECK(hapticd_order(session, 0) == HAPTICD_INVALID);
  CHECK(hapticd_order(session, 17) == HAPTICD_INVALID);
  REQUIRE(hapticd_acquire(session, "test") == HAPTICD_OK);
  CHECK(hapticd_set(session, "path", &value, 1) == HAPTICD_OK);
}

TEST_CASE("structs of the wrong size are refused, and of a newer one no more than all is written") {
  RealServer server;
  const Opened session(server.port());
  REQUIRE(hapticd_acquire(session, "test") == HAPTICD_OK);
  REQUIRE(hapticd_subscribe(session, 1) == HAPTICD_OK);
  struct Newer {
    hapticd_state state;
    std::array<char, 24> added;
    std::array<char, 8> beyond;
  } newer{};
  std::memset(static_cast<void*>(&newer), 'x', sizeof newer);
  hapticd_run_result result{};
  for (const std::uint32_t size : {0U, 63U, 65537U, 0xFFFFFFFFU}) {
    result.size = size;
    CHECK(hapticd_run(session, 4, nullptr, 0, &result) == HAPTICD_INVALID);
    newer.state.size = size;
    CHECK(hapticd_next_state(session, &newer.state) == HAPTICD_INVALID);
  }
  CHECK(hapticd_next_state(session, nullptr) == HAPTICD_INVALID);
  CHECK(hapticd_next_event(session, nullptr) == HAPTICD_INVALID);
  result.size = sizeof result;
  REQUIRE(hapticd_run(session, 4, nullptr, 0, &result) == HAPTICD_OK);
  CHECK(result.steps == 4);
  newer.state.size = sizeof newer.state + sizeof newer.added;
  for (std::uint64_t tick = 0; tick < 4; ++tick) {
    REQUIRE(hapticd_next_state(session, &newer.state) == 1);
    CHECK(newer.state.size == sizeof newer.state + sizeof newer.added);
    CHECK(newer.state.tick == tick);
    CHECK(newer.state.t_ns == 1'000'000 * tick);
  }
  CHECK(hapticd_next_state(session, &newer.state) == 0);
  for (const char byte : newer.added) CHECK(byte == 0);
  for (const char byte : newer.beyond) CHECK(byte == 'x');
}

TEST_CASE("a daemon that vanishes is told of, and one that comes back is joined") {
  auto server = std::make_unique<RealServer>();
  const std::uint16_t port = server->port();
  const Opened session(port);
  REQUIRE(hapticd_acquire(session, "test") == HAPTICD_OK);
  server.reset();
  const double value = 1.0;
  CHECK(hapticd_set(session, "path", &value, 1) == HAPTICD_SILENT);
  CHECK(hapticd_run(session, 10, &kPose, 1, nullptr) == HAPTICD_SILENT);
  CHECK(hapticd_poll(session, 1) == HAPTICD_OK);
  CHECK(std::strlen(hapticd_last_error(session)) > 10);
  server = std::make_unique<RealServer>(port, 12);
  int code = HAPTICD_SILENT;
  for (int tries = 0; code == HAPTICD_SILENT && tries < 100; ++tries) {
    code = hapticd_set(session, "path", &value, 1);
  }
  // The lease is gone with the daemon that gave it.
  CHECK(code == HAPTICD_REFUSED);
  CHECK(hapticd_acquire(session, "test") == HAPTICD_OK);
  CHECK(hapticd_run(session, 10, &kPose, 1, nullptr) == HAPTICD_OK);
}

TEST_CASE("sessions of several threads know nothing of each other") {
  RealServer server;
  std::array<std::uint64_t, 4> sums{};
  std::vector<std::thread> threads;
  threads.reserve(sums.size());
  for (std::uint64_t& sum : sums) {
    threads.emplace_back([&sum, port = server.port()] {
      const Opened session(port);
      if (hapticd_subscribe(session, 1) != HAPTICD_OK) return;
      hapticd_event event{};
      event.size = sizeof event;
      for (int k = 0; k < 200; ++k) {
        if (hapticd_poll(session, 0) == HAPTICD_OK && hapticd_next_event(session, &event) >= 0)
          ++sum;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::uint64_t sum : sums) CHECK(sum == 200);
}
