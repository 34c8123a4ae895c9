// A ProtocolServer on a real socket of loopback in a thread of its own, with a host that answers
// every request and runs steps: tick after tick, as fast as the server lets it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "server/network/udp_transport.h"

namespace hapticd::test {

class RealServer {
 public:
  explicit RealServer(std::uint16_t port = 0, std::uint32_t boot_id = 11)
      : transport_("127.0.0.1:" + std::to_string(port)) {
    ServerHost host;
    host.greeting = [] {
      std::vector<v1::Item> items(2);
      items[0].mutable_scene_info()->set_scene_id(1);
      items[1].mutable_record_info()->set_state(v1::RECORD_STATE_IDLE);
      return items;
    };
    host.request = [this](const RequestId& id, const v1::Item& item) { take(id, item); };
    host.abandoned = [this](const RequestId&) { run_.reset(); };
    host.fill_state = [](const Subscription&, v1::State& state) {
      state.set_t_ns(1'000'000 * state.tick());
    };
    host.lease_lost = [](LeaseEnd) {};
    server_ = std::make_unique<ProtocolServer>(
        ServerOptions{boot_id, true}, host,
        [this](const Address& to, std::span<const std::uint8_t> datagram) {
          transport_.send(to, datagram);
        });
    thread_ = std::thread(
        [this] { transport_.run(*server_, [this](std::int64_t now_ns) { return work(now_ns); }); });
  }
  ~RealServer() {
    transport_.stop();
    thread_.join();
  }
  RealServer(const RealServer&) = delete;
  RealServer& operator=(const RealServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return transport_.port(); }
  std::atomic<std::uint64_t> poses{0};
  std::atomic<std::uint64_t> ticks{0};  ///< played
  std::atomic<bool> say_bye{false};
  std::atomic<std::uint64_t> bye_at_tick{0};  ///< in the middle of a run; 0: never
  std::atomic<bool> tones{false};             ///< one with every tick
  std::atomic<bool> refuse_poses{false};      ///< NOT_FOUND
  /// What Results of runs say instead of the truth; 0: the truth.
  std::atomic<std::uint64_t> said_steps{0};
  std::atomic<std::uint64_t> said_next_tick{0};

 private:
  struct UnderWay {
    RequestId id;
    std::uint64_t steps;
    std::uint64_t done = 0;
  };

  void take(const RequestId& id, const v1::Item& item) {
    if (item.has_run()) {
      run_ = UnderWay{id, item.run().steps()};
      return;
    }
    poses += static_cast<std::uint64_t>(item.pose_batch().poses_size());
    const bool refused = item.has_pose_batch() && refuse_poses;
    v1::Result result;
    result.set_code(refused ? v1::RESULT_CODE_NOT_FOUND : v1::RESULT_CODE_OK);
    if (refused) result.set_message("There is no such tool.");
    server_->answer(id, result);
  }

  void play_tick(std::int64_t now_ns) {
    if (tones) {
      v1::Item item;
      item.mutable_tone()->set_t_ns(1'000'000 * tick_);
      server_->broadcast(item);
    }
    server_->offer_tick(tick_++, 1, now_ns);
    ++ticks;
  }

  bool work(std::int64_t now_ns) {
    if (say_bye.exchange(false)) server_->shut_down(v1::BYE_REASON_SHUTDOWN, "the end", now_ns);
    if (!run_.has_value()) return false;
    for (int burst = 0; burst < 16 && run_->done < run_->steps; ++burst) {
      if (!server_->may_step(now_ns)) return false;
      play_tick(now_ns);
      ++run_->done;
      if (tick_ == bye_at_tick) say_bye = true;
    }
    if (run_->done < run_->steps) return true;
    v1::Result result;
    result.set_code(v1::RESULT_CODE_OK);
    result.mutable_run()->set_steps(said_steps != 0 ? said_steps.load() : run_->done);
    result.mutable_run()->set_next_tick(said_next_tick != 0 ? said_next_tick.load() : tick_);
    const RequestId id = run_->id;
    run_.reset();
    server_->answer(id, result);
    return true;
  }

  UdpTransport transport_;
  std::optional<UnderWay> run_;
  std::uint64_t tick_ = 0;
  std::unique_ptr<ProtocolServer> server_;
  std::thread thread_;
};

}  // namespace hapticd::test
