// One real ProtocolServer and real ClientCores, joined by links that lose, repeat, delay and damage
// datagrams, under one virtual clock. Each client has a clock of its own, with offset and skew. The
// host records what it is asked and answers at once, or later when told to.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "clients/library/client_core.h"
#include "server/network/protocol_server.h"
#include "tests/support/lossy_link.h"
#include "tests/support/random.h"

namespace hapticd::test {

inline constexpr std::int64_t kTestMillisecond_ns = 1'000'000;
inline constexpr std::int64_t kTestSecond_ns = 1'000'000'000;

/// A client, its two links, and all it heard.
struct VirtualClient {
  VirtualClient(const LinkConditions& conditions, std::uint64_t seed, const Address& from)
      : address(from), to_server(conditions, seed), to_client(conditions, seed + 1) {}

  Address address;
  LossyLink to_server;
  LossyLink to_client;
  std::int64_t clock_offset_ns = 0;  ///< own clock minus the network's, at its time 0
  double clock_skew = 0.0;
  std::unique_ptr<client::ClientCore> core;

  std::vector<v1::Item> items;    ///< of the session that lives
  std::vector<v1::State> states;  ///< of the session that lives
  std::vector<v1::Result> refused_poses;
  std::vector<client::SessionEnd> ends;
  std::vector<Datagram> captured;  ///< everything it sent, when capturing
  std::vector<Datagram> captured_from_server;

  /// Own clock at the network's instant `at_ns`.
  [[nodiscard]] std::int64_t own_ns(std::int64_t at_ns) const {
    return at_ns + clock_offset_ns + std::llround(clock_skew * static_cast<double>(at_ns));
  }
  /// Indices of the strings of the Tones it heard.
  [[nodiscard]] std::vector<std::uint32_t> tones() const {
    std::vector<std::uint32_t> all;
    for (const v1::Item& item : items) {
      if (item.has_tone()) all.push_back(item.tone().string_index());
    }
    return all;
  }
};

class VirtualNetwork {
 public:
  explicit VirtualNetwork(const ServerOptions& options = {.boot_id = 7}) { start_server(options); }

  /// Ends the server without a word and starts another.
  void start_server(const ServerOptions& options) {
    asked.clear();
    host_answers = true;
    ServerHost host;
    host.greeting = [this] { return greeting; };
    host.request = [this](const RequestId& id, const v1::Item& item) {
      asked.push_back({id, item});
      if (host_answers) server->answer(id, result());
    };
    host.abandoned = [this](const RequestId& id) { abandoned.push_back(id); };
    host.fill_state = [this](const Subscription& subscription, v1::State& state) {
      if (fill) {
        fill(subscription, state);
      } else {
        state.set_t_ns(1000 * state.tick());
      }
    };
    host.lease_lost = [this](LeaseEnd how) { lease_ends.push_back(how); };
    server = std::make_unique<ProtocolServer>(
        options, host, [this](const Address& to, std::span<const std::uint8_t> datagram) {
          for (const auto& each : clients) {
            if (each->address != to) continue;
            each->to_client.send(datagram, now_ns);
            if (capturing)
              each->captured_from_server.emplace_back(datagram.begin(), datagram.end());
          }
        });
  }

  VirtualClient& add_client(const LinkConditions& conditions = {}, std::uint64_t seed = 1) {
    const auto port = static_cast<std::uint16_t>(50'000 + clients.size());
    clients.push_back(
        std::make_unique<VirtualClient>(conditions, seed, ipv4_address({127, 0, 0, 1}, port)));
    VirtualClient& mine = *clients.back();
    client::ClientHandlers handlers;
    handlers.item = [&mine](const v1::Item& item) { mine.items.push_back(item); };
    handlers.state = [&mine](const v1::State& state) { mine.states.push_back(state); };
    handlers.pose_refused = [&mine](const v1::Result& r) { mine.refused_poses.push_back(r); };
    handlers.ended = [&mine](client::SessionEnd how) {
      mine.ends.push_back(how);
      mine.items.clear();
      mine.states.clear();
    };
    auto random = std::make_shared<SplitMix64>(seed + 99);
    mine.core = std::make_unique<client::ClientCore>(
        [this, &mine](std::span<const std::uint8_t> datagram) {
          mine.to_server.send(datagram, now_ns);
          if (capturing) mine.captured.emplace_back(datagram.begin(), datagram.end());
        },
        [random] { return static_cast<std::uint32_t>(random->next()); }, handlers);
    return mine;
  }

  /// Lets `duration_ns` pass in steps of 500 us, or until `done` says so. Whether it did.
  template <typename Done>
  bool run_until(std::int64_t duration_ns, const Done& done) {
    const std::int64_t end_ns = now_ns + duration_ns;
    while (now_ns < end_ns) {
      if (done()) return true;
      step();
    }
    return done();
  }
  void run_for(std::int64_t duration_ns) {
    run_until(duration_ns, [] { return false; });
  }

  void step() {
    now_ns += 500'000;
    for (const auto& each : clients) {
      for (const Datagram& datagram : each->to_server.arrived(now_ns)) {
        server->receive(each->address, datagram, now_ns);
      }
    }
    if (tick_each_step) server->offer_tick(tick++, scene_id, now_ns);
    server->poll(now_ns);
    for (const auto& each : clients) {
      const std::int64_t own_ns = each->own_ns(now_ns);
      for (const Datagram& datagram : each->to_client.arrived(now_ns)) {
        each->core->receive(datagram, own_ns);
      }
      each->core->poll(own_ns);
    }
  }

  static v1::Result result(v1::ResultCode code = v1::RESULT_CODE_OK) {
    v1::Result answer;
    answer.set_code(code);
    return answer;
  }

  struct Asked {
    RequestId id;
    v1::Item item;
  };

  std::int64_t now_ns = kTestSecond_ns;
  std::vector<std::unique_ptr<VirtualClient>> clients;
  std::vector<v1::Item> greeting = usual_greeting();
  std::function<void(const Subscription&, v1::State&)> fill;
  bool host_answers = true;
  bool capturing = false;
  bool tick_each_step = false;
  std::uint64_t tick = 0;
  std::uint32_t scene_id = 1;
  std::vector<Asked> asked;
  std::vector<RequestId> abandoned;
  std::vector<LeaseEnd> lease_ends;
  std::unique_ptr<ProtocolServer> server;

 private:
  static std::vector<v1::Item> usual_greeting() {
    std::vector<v1::Item> items(2);
    items[0].mutable_scene_info()->set_scene_id(1);
    items[1].mutable_record_info()->set_state(v1::RECORD_STATE_IDLE);
    return items;
  }
};

inline v1::Item tone_item(std::uint32_t string_index) {
  v1::Item item;
  item.mutable_tone()->set_string_index(string_index);
  return item;
}

/// A request with a number in it, for the host.
inline v1::Item numbered_request(std::uint64_t number) {
  v1::Item item;
  item.mutable_get_parameters()->add_paths(std::to_string(number));
  return item;
}

}  // namespace hapticd::test
