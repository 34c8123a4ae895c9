// One real ProtocolServer and real ClientCores, joined by links that lose, repeat, delay and damage
// datagrams, under one virtual clock. Each client has a clock of its own, with offset and skew. The
// host records what it is asked and answers at once, or later when told to.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clients/library/client_core.h"
#include "server/network/protocol_server.h"
#include "tests/server/network/recording_host.h"
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

/// 32 equal bytes.
inline noise::SecretKey even_key(std::uint8_t byte) {
  return noise::SecretKey::filled([byte](noise::Key& key) { key.fill(byte); });
}
/// Keys of a server, for tests.
inline noise::ServerKeys network_keys() {
  return noise::server_keys(even_key(0x33), even_key(0x11), even_key(0x22));
}
inline client::ClientKey control_key() {
  return {wire::Role::kControl, even_key(0x22), network_keys().server};
}

/// Options of a server with network_keys(), its randomness seeded.
inline ServerOptions keyed_network(std::uint32_t boot_id = 7, std::uint64_t seed = 1) {
  auto random = std::make_shared<SplitMix64>(seed);
  return {
      .boot_id = boot_id, .keys = network_keys(), .random = [random](std::span<std::uint8_t> all) {
        for (std::uint8_t& byte : all) byte = static_cast<std::uint8_t>(random->next() >> 56U);
      }};
}

class VirtualNetwork {
 public:
  explicit VirtualNetwork(const ServerOptions& options = {.boot_id = 7}) { start_server(options); }

  /// Ends the server without a word and starts another.
  void start_server(const ServerOptions& options) {
    host.asked.clear();
    host.answers = true;
    if (!host.fill) {
      host.fill = [](const Subscription&, v1::State& state) {
        state.set_t_ns(1000 * state.tick());
      };
    }
    server = std::make_unique<ProtocolServer>(
        options, host.functions([this](const RequestId& id, v1::Result result) {
          server->answer(id, std::move(result));
        }),
        [this](const Address& to, std::span<const std::uint8_t> datagram) {
          for (const auto& each : clients) {
            if (each->address != to) continue;
            each->to_client.send(datagram, now_ns);
            if (capturing)
              each->captured_from_server.emplace_back(datagram.begin(), datagram.end());
          }
        });
  }

  /// With a key it speaks to a server started with network_keys().
  VirtualClient& add_client(const LinkConditions& conditions = {}, std::uint64_t seed = 1,
                            std::optional<client::ClientKey> key = std::nullopt) {
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
        [random] { return static_cast<std::uint32_t>(random->next()); }, handlers, key);
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

  std::int64_t now_ns = kTestSecond_ns;
  std::vector<std::unique_ptr<VirtualClient>> clients;
  RecordingHost host;
  bool capturing = false;
  bool tick_each_step = false;
  std::uint64_t tick = 0;
  std::uint32_t scene_id = 1;
  std::unique_ptr<ProtocolServer> server;
};

/// A network as bad as it may get: up to 60 % loss, 25 % twice, 50 ms out of order.
inline LinkConditions bad_conditions(SplitMix64& random) {
  LinkConditions conditions;
  conditions.loss = random.chance(0.2) ? 0.0 : random.uniform(0.0, 0.6);
  conditions.duplication = random.uniform(0.0, 0.25);
  conditions.delay_ns = static_cast<std::int64_t>(random.below(5'000'000));
  conditions.jitter_ns =
      random.chance(0.3) ? 0 : static_cast<std::int64_t>(random.below(50'000'000));
  return conditions;
}

inline v1::Item tone_item(std::uint32_t string_index) {
  v1::Item item;
  item.mutable_tone()->set_string_index(string_index);
  return item;
}

/// 0, 1, ... below `count`.
inline std::vector<std::uint32_t> up_to(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

/// A request with a number in it, for the host.
inline v1::Item numbered_request(std::uint64_t number) {
  v1::Item item;
  item.mutable_get_parameters()->add_paths(std::to_string(number));
  return item;
}

}  // namespace hapticd::test
