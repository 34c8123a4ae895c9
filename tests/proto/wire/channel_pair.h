// Two Channels, a client's and a server's, joined by links under one virtual clock, as their owners
// poll them: whatever has arrived is taken, then what is due leaves, 32 Packets at most. Each side
// may be one of before Packet.ahead: what it says of it is cut out.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/wire/channel.h"
#include "tests/support/lossy_link.h"

namespace hapticd::wire {

inline constexpr std::int64_t kStep_ns = kMillisecond_ns / 2;

inline std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// One side, the link from it, and what it heard.
struct ChannelSide {
  ChannelSide(Side side, bool is_new, const test::LinkConditions& conditions, std::uint64_t seed)
      : channel(side, 7),
        speaks(side == Side::kClient),
        takes_ahead(is_new),
        out(conditions, seed) {}

  Channel channel;
  bool speaks;  ///< a server has no session before its client's first Packet
  bool takes_ahead;
  test::LossyLink out;
  std::vector<v1::Item> heard;
  std::size_t packets = 0;       ///< that left
  std::size_t with_items = 0;    ///< of them
  std::uint64_t highest_id = 0;  ///< of the Items in them
};

class ChannelPair {
 public:
  ChannelPair(const test::LinkConditions& conditions, std::uint64_t seed,
              bool client_takes_ahead = true, bool server_takes_ahead = true)
      : client(Side::kClient, client_takes_ahead, conditions, seed),
        server(Side::kServer, server_takes_ahead, conditions, seed + 1) {}

  /// 500 us pass.
  void step() {
    now_ns += kStep_ns;
    turn(client, server);
    turn(server, client);
  }
  /// Steps until `done()`, at most so many; the steps it took, or nothing.
  template <typename Done>
  std::optional<int> steps_until(int most, const Done& done) {
    for (int steps = 0; steps < most; ++steps) {
      if (done()) return steps;
      step();
    }
    return done() ? std::optional<int>(most) : std::nullopt;
  }

  std::int64_t now_ns = 1000 * kMillisecond_ns;
  ChannelSide client;
  ChannelSide server;

 private:
  void turn(ChannelSide& from, ChannelSide& to) {
    for (const test::Datagram& datagram : from.out.arrived(now_ns)) {
      const auto header = decode_header(datagram);
      REQUIRE(header.has_value());
      v1::Packet packet;
      REQUIRE(parse_packet(std::span(datagram).subspan(kHeaderBytes), packet));
      const bool both = to.takes_ahead && from.takes_ahead;
      const bool early = packet.items_size() > 0 && packet.first() > to.channel.applied() + 1;
      REQUIRE((both || !early));
      if (!both) packet.clear_ahead();
      const std::string body = packet.SerializeAsString();
      to.speaks = true;
      Incoming incoming = to.channel.receive(*header, bytes_of(body), now_ns);
      REQUIRE(incoming.items.broken == nullptr);
      for (ReceivedItem& each : incoming.items.items) to.heard.push_back(std::move(each.item));
    }
    for (int i = 0; to.speaks && i < 32 && to.channel.due_ns() <= now_ns; ++i) send(to);
  }

  void send(ChannelSide& from) {
    std::string datagram;
    REQUIRE(from.channel.write({}, now_ns, datagram));
    REQUIRE(datagram.size() <= kDatagramBytes);
    v1::Packet packet;
    REQUIRE(parse_packet(bytes_of(datagram).subspan(kHeaderBytes), packet));
    ++from.packets;
    from.with_items += packet.items_size() > 0;
    if (packet.items_size() > 0) {
      from.highest_id = std::max(
          from.highest_id, packet.first() + static_cast<std::uint64_t>(packet.items_size()) - 1);
    }
    from.out.send(bytes_of(datagram), now_ns);
  }
};

}  // namespace hapticd::wire
