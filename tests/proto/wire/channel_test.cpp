// One side of a session: steps 4 to 6, acknowledging, keeping alive. PROTOCOL.md, sections 2 to 4.
#include "proto/wire/channel.h"

#include <doctest/doctest.h>

#include <string>

namespace hapticd::wire {
namespace {

v1::Item tone(std::uint32_t string_index) {
  v1::Item item;
  item.mutable_tone()->set_string_index(string_index);
  return item;
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// What `to` makes of a Packet with this counter.
Incoming give(Channel& to, std::uint64_t counter, const v1::Packet& packet, std::int64_t now = 1) {
  const std::string body = packet.SerializeAsString();
  return to.receive({DatagramKind::kPlain, to.session(), counter}, bytes_of(body), now);
}

v1::Packet empty_packet() {
  v1::Packet packet;
  packet.set_first(1);
  return packet;
}

/// The next datagram of `from`, parsed.
v1::Packet taken_from(Channel& from, std::int64_t now, const v1::Packet& rest = {},
                      std::optional<std::string_view> state = std::nullopt) {
  std::string datagram;
  REQUIRE(from.write(rest, now, datagram, state));
  CHECK(datagram.size() <= kDatagramBytes);
  v1::Packet packet;
  REQUIRE(parse_packet(bytes_of(datagram).subspan(kHeaderBytes), packet));
  return packet;
}

TEST_CASE("a counter is taken once, and only marked when the body opens") {
  Channel channel(Side::kServer, 5);
  v1::Packet broken = empty_packet();
  broken.set_first(0);
  CHECK(give(channel, 3, broken).verdict == Verdict::kUnreadable);
  CHECK(give(channel, 3, empty_packet()).verdict == Verdict::kTaken);
  CHECK(give(channel, 3, empty_packet()).verdict == Verdict::kRepeated);
  const Incoming older = give(channel, 2, empty_packet());
  CHECK(older.verdict == Verdict::kTaken);
  CHECK(!older.newest);
}

TEST_CASE("what is no Packet, and a Packet of more than 16 Items, is unreadable") {
  Channel channel(Side::kServer, 5);
  const std::string junk = "\xff\xff\xff";
  CHECK(channel.receive({DatagramKind::kPlain, 5, 0}, bytes_of(junk), 1).verdict ==
        Verdict::kUnreadable);
  v1::Packet packet = empty_packet();
  for (int i = 0; i < 17; ++i) packet.add_items();
  CHECK(give(channel, 0, packet).verdict == Verdict::kUnreadable);
  packet.mutable_items()->RemoveLast();
  CHECK(give(channel, 0, packet).verdict == Verdict::kTaken);
}

TEST_CASE("counters grow by one with every datagram, from 0") {
  Channel channel(Side::kClient, 0x1234abcd);
  for (std::uint64_t counter = 0; counter < 3; ++counter) {
    std::string datagram;
    REQUIRE(channel.write({}, 1, datagram));
    const auto header = decode_header(bytes_of(datagram));
    REQUIRE(header.has_value());
    CHECK(*header == DatagramHeader{DatagramKind::kPlain, 0x1234abcd, counter});
  }
}

TEST_CASE("a new Item is acknowledged at once, one that came again 5 ms after the last Packet") {
  Channel channel(Side::kServer, 5);
  v1::Packet packet = empty_packet();
  *packet.add_items() = tone(1);
  std::int64_t now = 1000 * kMillisecond_ns;
  taken_from(channel, now);
  CHECK(channel.due_ns() == now + kKeepAlive_ns);
  give(channel, 0, packet, now);
  CHECK(channel.due_ns() == 0);
  CHECK(taken_from(channel, now).ack() == 1);
  CHECK(channel.due_ns() == now + kKeepAlive_ns);
  give(channel, 1, packet, now + kMillisecond_ns);
  CHECK(channel.due_ns() == now + kAcknowledgeAgain_ns);
  give(channel, 2, packet, now + 20 * kMillisecond_ns);
  CHECK(channel.due_ns() <= now + 20 * kMillisecond_ns);
}

TEST_CASE("a Packet leaves 100 ms after the last one, and the first one at once") {
  Channel channel(Side::kClient, 5);
  CHECK(channel.due_ns() == 0);
  taken_from(channel, 7 * kMillisecond_ns);
  CHECK(channel.due_ns() == 107 * kMillisecond_ns);
}

TEST_CASE("an acknowledgement of what was never sent breaks the session") {
  Channel channel(Side::kServer, 5);
  channel.send(tone(1));
  v1::Packet packet = empty_packet();
  packet.set_ack(1);
  CHECK(give(channel, 0, packet).items.broken != nullptr);
  taken_from(channel, 1);
  CHECK(give(channel, 1, packet).items.broken == nullptr);
  CHECK(channel.all_acknowledged());
}

TEST_CASE("a State that does not fit beside the Items goes alone, and the Items go on their own") {
  Channel channel(Side::kServer, 5);
  v1::Item item;
  item.mutable_result()->set_message(std::string(600, 'x'));
  channel.send(item);
  v1::State state;
  state.mutable_replay()->set_tick(1);
  const std::string first = state.SerializeAsString();
  const v1::Packet beside = taken_from(channel, 1, {}, first);
  CHECK(beside.items_size() == 1);
  CHECK(beside.state().replay().tick() == 1);
  for (int i = 0; i < 60; ++i) state.add_tools()->add_p_wh_m(1.0);
  const std::string second = state.SerializeAsString();
  const v1::Packet alone = taken_from(channel, 2, {}, second);
  CHECK(alone.items_size() == 0);
  CHECK(alone.first() == 1);
  CHECK(alone.state().tools_size() == 60);
}

TEST_CASE("a State in which everything is 0 is there all the same") {
  Channel channel(Side::kServer, 5);
  CHECK(taken_from(channel, 1, {}, "").has_state());
  CHECK(!taken_from(channel, 2).has_state());
}

TEST_CASE("a State of as many bytes as offered fits, one byte more does not") {
  Channel channel(Side::kServer, 5);
  v1::Packet rest;
  rest.set_boot_id(5);
  const std::size_t bytes = channel.state_bytes(rest);
  CHECK(bytes > 1000);
  v1::State state;
  state.add_gestures();
  std::string& name = *state.mutable_gestures(0)->mutable_name();
  while (state.ByteSizeLong() < bytes) name += 'x';
  REQUIRE(state.ByteSizeLong() == bytes);
  std::string datagram;
  CHECK(channel.write(rest, 1, datagram, state.SerializeAsString()));
  CHECK(datagram.size() + kTagBytes == kDatagramBytes);
  name += 'x';
  CHECK(!channel.write(rest, 1, datagram, state.SerializeAsString()));
}

TEST_CASE("a client takes a Reset whose counter was used; a server takes none") {
  v1::Packet reset = empty_packet();
  reset.mutable_reset()->set_reason(v1::RESET_REASON_UNKNOWN_SESSION);
  Channel client(Side::kClient, 5);
  CHECK(give(client, 0, empty_packet()).verdict == Verdict::kTaken);
  const Incoming taken = give(client, 0, reset);
  CHECK(taken.verdict == Verdict::kTaken);
  CHECK(taken.packet.has_reset());
  CHECK(give(client, 0, empty_packet()).verdict == Verdict::kRepeated);
  Channel server(Side::kServer, 5);
  CHECK(give(server, 0, empty_packet()).verdict == Verdict::kTaken);
  CHECK(give(server, 0, reset).verdict == Verdict::kRepeated);
}

TEST_CASE("a Reset marks no counter and applies no Items") {
  Channel client(Side::kClient, 5);
  v1::Packet reset = empty_packet();
  reset.mutable_reset();
  *reset.add_items() = tone(1);
  CHECK(give(client, 0, reset).items.items.empty());
  CHECK(client.applied() == 0);
  CHECK(give(client, 0, empty_packet()).verdict == Verdict::kTaken);
}

/// The ciphers of both sides of a handshake, client's first.
std::pair<noise::Transport, noise::Transport> transports() {
  noise::Key psk{};
  noise::Key first{1};
  noise::Key second{2};
  noise::Handshake client(noise::Side::kInitiator, psk, {}, first);
  noise::Handshake server(noise::Side::kResponder, psk, {}, second);
  REQUIRE(server.read(client.write().value()).has_value());
  REQUIRE(client.read(server.write().value()).has_value());
  return {client.split(), server.split()};
}

TEST_CASE("a secured channel speaks DATA, and keeps what was sent before") {
  const auto ciphers = transports();
  Channel client(Side::kClient, 0);
  client.send(tone(1));
  client.secure(77, ciphers.first);
  CHECK(client.session() == 77);
  std::string datagram;
  REQUIRE(client.write({}, 1, datagram));
  const auto header = decode_header(bytes_of(datagram));
  CHECK(header == DatagramHeader{DatagramKind::kData, 77, 0});
  v1::Packet none;
  CHECK(!parse_packet(bytes_of(datagram).subspan(kHeaderBytes), none));
  Channel server(Side::kServer, 77);
  server.secure(77, ciphers.second);
  std::string forged = datagram;
  forged.back() ^= 1;
  const auto body = [](const std::string& all) { return bytes_of(all).subspan(kHeaderBytes); };
  CHECK(server.receive(*header, body(forged), 1).verdict == Verdict::kForged);
  CHECK(server.receive({DatagramKind::kData, 77, 1}, body(datagram), 1).verdict ==
        Verdict::kForged);
  CHECK(server.receive({DatagramKind::kData, 78, 0}, body(datagram), 1).verdict ==
        Verdict::kForged);
  const Incoming incoming = server.receive(*header, body(datagram), 1);
  CHECK(incoming.verdict == Verdict::kTaken);
  CHECK(incoming.items.items.size() == 1);
  CHECK(server.receive(*header, body(datagram), 1).verdict == Verdict::kRepeated);
}

TEST_CASE("the largest datagram of a secured channel has 1200 bytes") {
  Channel channel(Side::kServer, 0);
  channel.secure(77, transports().second);
  v1::State state;
  std::string& name = *state.add_gestures()->mutable_name();
  while (state.ByteSizeLong() < channel.state_bytes({})) name += 'x';
  const std::string encoded = state.SerializeAsString();
  std::string datagram;
  CHECK(channel.write({}, 1, datagram, encoded));
  CHECK(datagram.size() == kDatagramBytes);
}

}  // namespace
}  // namespace hapticd::wire
