// A ProtocolServer on a real socket of loopback, in a thread of its own: a scene, a tick every
// millisecond or so, a Tone when the test says so, and requests answered OK. With keys or without.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/network/udp_transport.h"

namespace hapticd::test {

class FakeDaemon {
 public:
  explicit FakeDaemon(std::uint16_t port = 0, std::uint32_t boot_id = 11,
                      std::optional<noise::ServerKeys> keys = std::nullopt)
      : transport_("127.0.0.1:" + std::to_string(port), keys.has_value()) {
    ServerHost host;
    host.greeting = [] {
      std::vector<v1::Item> items(2);
      items[0].mutable_scene_info()->set_scene_id(1);
      items[0].mutable_scene_info()->set_rate_hz(1000.0);
      items[0].mutable_scene_info()->set_hash(std::string(32, 's'));
      items[1].mutable_record_info()->set_state(v1::RECORD_STATE_IDLE);
      return items;
    };
    host.request = [this](const RequestId& id, const v1::Item& item) {
      {
        const std::lock_guard lock(mutex_);
        requests_.push_back(item);
      }
      v1::Result result;
      result.set_code(v1::RESULT_CODE_OK);
      server_->answer(id, result);
    };
    host.abandoned = [](const RequestId&) {};
    host.fill_state = [this](const Subscription& subscription, v1::State& state) {
      divisor = subscription.divisor;
      state.set_t_ns(1'000'000 * state.tick());
      state.set_loop_state(v1::LOOP_STATE_ENGAGED);
    };
    host.lease_lost = [](LeaseEnd) {};
    server_ = std::make_unique<ProtocolServer>(
        ServerOptions{boot_id, false, keys}, host,
        [this](const Address& to, std::span<const std::uint8_t> datagram) {
          transport_.send(to, datagram);
        });
    thread_ = std::thread(
        [this] { transport_.run(*server_, [this](std::int64_t now_ns) { return work(now_ns); }); });
  }
  ~FakeDaemon() {
    transport_.stop();
    thread_.join();
  }
  FakeDaemon(const FakeDaemon&) = delete;
  FakeDaemon& operator=(const FakeDaemon&) = delete;

  [[nodiscard]] std::uint16_t port() const { return transport_.port(); }
  /// Requests that reached the host so far.
  std::vector<v1::Item> requests() {
    const std::lock_guard lock(mutex_);
    return requests_;
  }
  /// Says so many Tones more, numbered by string.
  void play(std::uint32_t tones) { tones_ += tones; }

  std::atomic<std::uint32_t> divisor{0};
  std::atomic<bool> say_bye{false};

 private:
  bool work(std::int64_t now_ns) {
    if (say_bye.exchange(false)) server_->shut_down(v1::BYE_REASON_SHUTDOWN, "the end", now_ns);
    for (; told_ < tones_.load(); ++told_) {
      v1::Item tone;
      tone.mutable_tone()->set_string_index(told_);
      server_->broadcast(tone);
    }
    if (now_ns - ticked_ns_ >= 1'000'000) {
      ticked_ns_ = now_ns;
      server_->offer_tick(tick_++, 1, now_ns);
    }
    return false;
  }

  UdpTransport transport_;
  std::unique_ptr<ProtocolServer> server_;
  std::mutex mutex_;
  std::vector<v1::Item> requests_;
  std::atomic<std::uint32_t> tones_{0};
  std::uint32_t told_ = 0;
  std::uint64_t tick_ = 0;
  std::int64_t ticked_ns_ = 0;
  std::thread thread_;
};

}  // namespace hapticd::test
