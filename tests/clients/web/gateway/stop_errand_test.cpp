// A page's Stop on its way to a real Stop road on loopback, with a loop that ticks when a test says
// so.
#include "clients/web/gateway/stop_errand.h"

#include <doctest/doctest.h>
#include <sodium.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "server/haptic_loop/stop_line.h"
#include "server/stop_road/stop_road.h"

namespace hapticd::test {
namespace {

constexpr std::uint16_t kSessionPort = 47800;

/// A road, and a loop that latches each Stop; a Stop that comes while it is in FAULT is counted
/// too.
class Daemon {
 public:
  explicit Daemon(std::uint16_t session_port = kSessionPort)
      : road_({"127.0.0.1", 0, false, {std::nullopt, session_port, {}}}, line_) {
    road_.start();
    loop_ = std::thread([this] {
      for (std::uint64_t tick = 0; !over_.load(); ++tick) {
        if (line_.take()) stops_.fetch_add(1);
        line_.tell(tick, stops_.load() > 0 ? LoopState::kFault : LoopState::kEngaged,
                   stops_.load() > 0 ? Cause::kStopped : Cause::kNone);
        std::this_thread::yield();
      }
    });
  }
  ~Daemon() {
    over_.store(true);
    loop_.join();
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  [[nodiscard]] std::uint16_t port() const { return road_.port(); }
  [[nodiscard]] int stops() const { return stops_.load(); }

 private:
  StopLine line_;
  StopRoad road_;
  std::atomic<int> stops_{0};
  std::atomic<bool> over_{false};
  std::thread loop_;
};

/// A gateway that has nothing but the errand.
struct Gateway {
  explicit Gateway(std::uint16_t port)
      : errand(context, {"127.0.0.1", port, {kSessionPort, std::nullopt}},
               [this](client::ResultHandler done) { by_session.push_back(std::move(done)); }) {}

  void stop() {
    errand.run([this](const v1::Result* result) {
      if (result != nullptr && result->code() == v1::RESULT_CODE_OK) ++answered;
    });
  }
  /// Until all that was asked for has been answered, or handed on to the session.
  void run(std::size_t asked) {
    const auto work = boost::asio::make_work_guard(context);
    while (answered + by_session.size() < asked) context.run_one();
  }

  boost::asio::io_context context;
  std::vector<client::ResultHandler> by_session;
  std::size_t answered = 0;
  web::StopErrand errand;
};

TEST_CASE("a page's Stop is latched by the road, and answered then") {
  REQUIRE(sodium_init() >= 0);
  const Daemon daemon;
  Gateway gateway(daemon.port());
  gateway.stop();
  gateway.run(1);
  CHECK(gateway.answered == 1);
  CHECK(gateway.by_session.empty());
  CHECK(daemon.stops() == 1);
}

TEST_CASE("a Stop that is asked for while one is under way is one more, after it") {
  REQUIRE(sodium_init() >= 0);
  const Daemon daemon;
  Gateway gateway(daemon.port());
  for (int k = 0; k < 5; ++k) gateway.stop();
  gateway.run(5);
  CHECK(gateway.answered == 5);
  CHECK(daemon.stops() >= 2);
}

TEST_CASE("where the road is of no use, the session is asked") {
  REQUIRE(sodium_init() >= 0);
  SUBCASE("the daemon has none") {
    Gateway gateway(0);
    gateway.stop();
    gateway.run(1);
    CHECK(gateway.by_session.size() == 1);
  }
  SUBCASE("another daemon's is there") {
    const Daemon other(kSessionPort + 1);
    Gateway gateway(other.port());
    gateway.stop();
    gateway.run(1);
    CHECK(gateway.by_session.size() == 1);
    CHECK(other.stops() == 0);
  }
  SUBCASE("nobody is there any more") {
    std::uint16_t port = 0;
    {
      const Daemon gone;
      port = gone.port();
    }
    Gateway gateway(port);
    gateway.stop();
    gateway.run(1);
    CHECK(gateway.by_session.size() == 1);
  }
}

}  // namespace
}  // namespace hapticd::test
