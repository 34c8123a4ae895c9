// A ProtocolServer with a host that records, and clients made of nothing but Packets: what they
// send is written here field by field, so the server is judged by the document and not by the
// other half of our own code.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hapticd/v1/stream.pb.h"
#include "server/network/protocol_server.h"
#include "tests/server/network/recording_host.h"

namespace hapticd::test {

inline constexpr std::int64_t kTestMs = 1'000'000;

/// A datagram the server sent.
struct SentDatagram {
  std::int64_t at_ns = 0;
  Address to;
  std::uint32_t session = 0;
  std::uint64_t counter = 0;
  std::size_t bytes = 0;
  v1::Packet packet;              ///< of PLAIN
  std::vector<std::uint8_t> raw;  ///< all of it
};

/// 'H', major, kind, 0, session, counter.
inline std::vector<std::uint8_t> raw_header(std::uint8_t kind, std::uint32_t session,
                                            std::uint64_t counter) {
  std::vector<std::uint8_t> bytes{0x48, 1, kind, 0};
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(session >> (8 * i)));
  for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::uint8_t>(counter >> (8 * i)));
  return bytes;
}

/// The bytes of a PLAIN datagram.
inline std::vector<std::uint8_t> plain_datagram(std::uint32_t session, std::uint64_t counter,
                                                const v1::Packet& packet) {
  std::vector<std::uint8_t> bytes = raw_header(5, session, counter);
  const std::string body = packet.SerializeAsString();
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

/// The server, its host, and everything it sent.
class ServerBench {
 public:
  explicit ServerBench(ServerOptions options = {.boot_id = 0xc0ffee}) {
    if (!options.work_time) options.work_time = [] { return std::int64_t{0}; };
    server = std::make_unique<ProtocolServer>(
        options, host.functions([this](const RequestId& id, v1::Result result) {
          server->answer(id, std::move(result));
        }),
        [this, plain = !options.keys.has_value()](const Address& to,
                                                  std::span<const std::uint8_t> bytes) {
          SentDatagram datagram{now_ns, to, 0, 0, bytes.size(), {}, {bytes.begin(), bytes.end()}};
          REQUIRE(bytes.size() > 16);
          REQUIRE((bytes[2] == 5) == plain);
          for (std::size_t i = 0; i < 4; ++i)
            datagram.session |= std::uint32_t{bytes[4 + i]} << (8 * i);
          for (std::size_t i = 0; i < 8; ++i)
            datagram.counter |= std::uint64_t{bytes[8 + i]} << (8 * i);
          if (plain) {
            REQUIRE(datagram.packet.ParseFromArray(bytes.data() + 16,
                                                   static_cast<int>(bytes.size() - 16)));
          }
          sent.push_back(datagram);
        });
  }

  void receive(const Address& from, std::span<const std::uint8_t> bytes) {
    server->receive(from, bytes, now_ns);
  }
  /// Lets `ms` pass in polls of 500 us.
  void pass(std::int64_t ms) {
    for (std::int64_t i = 0; i < 2 * ms; ++i) {
      now_ns += kTestMs / 2;
      server->poll(now_ns);
    }
  }
  void offer(std::uint64_t tick, std::uint32_t scene_id = 1) {
    server->offer_tick(tick, scene_id, now_ns);
  }

  std::int64_t now_ns = 1000 * kTestMs;
  RecordingHost host;
  std::vector<SentDatagram> sent;
  std::unique_ptr<ProtocolServer> server;
};

/// A client that acknowledges by hand.
class RawPeer {
 public:
  RawPeer(ServerBench& bench, std::uint32_t session, std::uint16_t port = 40'000)
      : RawPeer(bench, session, ipv4_address({127, 0, 0, 1}, port)) {}
  RawPeer(ServerBench& bench, std::uint32_t session, const Address& address)
      : bench_(bench), session_(session), address_(address) {}

  /// Sends a Packet with these new Items; earlier ones count as acknowledged.
  void send(const std::vector<v1::Item>& items, v1::Packet packet = {}) {
    packet.set_first(next_id_);
    for (const v1::Item& item : items) *packet.add_items() = item;
    next_id_ += items.size();
    packet.set_ack(applied());
    send_packet(packet);
  }
  void send(const v1::Item& item) { send(std::vector<v1::Item>{item}); }
  /// Sends a Packet without Items, with `ack` as far as everything arrived.
  void keep_alive(v1::Packet packet = {}) { send(std::vector<v1::Item>{}, std::move(packet)); }
  void send_packet(const v1::Packet& packet) {
    bench_.receive(address_, plain_datagram(session_, counter_++, packet));
  }
  /// Lets time pass, saying something every 50 ms.
  void pass(std::int64_t ms) {
    for (std::int64_t i = 0; i < ms; i += 50) {
      bench_.pass(50);
      keep_alive();
    }
  }

  /// Datagrams to this session, in order.
  [[nodiscard]] std::vector<SentDatagram> received() const {
    std::vector<SentDatagram> mine;
    for (const SentDatagram& datagram : bench_.sent) {
      if (datagram.to == address_ && datagram.session == session_) mine.push_back(datagram);
    }
    return mine;
  }
  /// All Items it was sent, by id; one sent again must be the same.
  [[nodiscard]] std::map<std::uint64_t, v1::Item> items() const {
    std::map<std::uint64_t, v1::Item> all;
    for (const SentDatagram& datagram : received()) {
      std::uint64_t id = datagram.packet.first();
      for (const v1::Item& item : datagram.packet.items()) {
        const auto [place, added] = all.emplace(id++, item);
        CHECK(place->second.SerializeAsString() == item.SerializeAsString());
      }
    }
    return all;
  }
  [[nodiscard]] std::uint64_t applied() const {
    const auto all = items();
    return all.empty() ? 0 : all.rbegin()->first;
  }
  /// Results by the id of the request.
  [[nodiscard]] std::map<std::uint64_t, v1::Result> results() const {
    std::map<std::uint64_t, v1::Result> all;
    for (const auto& [id, item] : items()) {
      if (item.has_result()) CHECK(all.emplace(item.result().item_id(), item.result()).second);
    }
    return all;
  }
  /// Code of the Result of request `id`; UNSPECIFIED if there is none.
  [[nodiscard]] v1::ResultCode code(std::uint64_t id) const {
    const auto all = results();
    return all.count(id) == 0 ? v1::RESULT_CODE_UNSPECIFIED : all.at(id).code();
  }
  /// The newest LeaseInfo.
  [[nodiscard]] v1::LeaseInfo lease() const {
    v1::LeaseInfo newest;
    for (const auto& [id, item] : items()) {
      if (item.has_lease_info()) newest = item.lease_info();
    }
    return newest;
  }
  /// Reason of the Bye it was sent; UNSPECIFIED if there is none.
  [[nodiscard]] v1::ByeReason bye() const {
    for (const auto& [id, item] : items()) {
      if (item.has_bye()) return item.bye().reason();
    }
    return v1::BYE_REASON_UNSPECIFIED;
  }
  [[nodiscard]] std::vector<v1::State> states() const {
    std::vector<v1::State> all;
    for (const SentDatagram& datagram : received()) {
      if (datagram.packet.has_state()) all.push_back(datagram.packet.state());
    }
    return all;
  }
  [[nodiscard]] std::uint64_t next_id() const { return next_id_; }
  [[nodiscard]] const Address& address() const { return address_; }

 private:
  ServerBench& bench_;
  std::uint32_t session_;
  Address address_;
  std::uint64_t counter_ = 0;
  std::uint64_t next_id_ = 1;
};

inline v1::Item ping_item() {
  v1::Item item;
  item.mutable_ping();
  return item;
}
inline v1::Item acquire_item(const std::string& holder, std::uint64_t fence = 0) {
  v1::Item item;
  item.mutable_acquire()->set_holder(holder);
  item.set_fence(fence);
  return item;
}
inline v1::Item release_item() {
  v1::Item item;
  item.mutable_release();
  return item;
}
inline v1::Item subscribe_item(std::uint32_t divisor) {
  v1::Item item;
  item.mutable_subscribe()->set_divisor(divisor);
  return item;
}
inline v1::Item run_item(v1::RunMode mode, std::uint64_t steps = 0) {
  v1::Item item;
  item.mutable_run()->set_mode(mode);
  item.mutable_run()->set_steps(steps);
  return item;
}
inline v1::Item stop_item() {
  v1::Item item;
  item.mutable_stop();
  return item;
}
inline v1::Item engage_item(std::uint64_t fence = 0) {
  v1::Item item;
  item.mutable_engage();
  item.set_fence(fence);
  return item;
}
inline v1::Item bye_item() {
  v1::Item item;
  item.mutable_bye()->set_reason(v1::BYE_REASON_DONE);
  return item;
}

}  // namespace hapticd::test
