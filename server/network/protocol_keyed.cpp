// See protocol_server.h: what arrives at a server with keys. PROTOCOL.md, section 12.
#include "server/network/protocol_state.h"

namespace hapticd {

using Implementation = ProtocolServer::Implementation;

void Implementation::receive_keyed(const Address& from, const wire::DatagramHeader& header,
                                   std::span<const std::uint8_t> received) {
  if (header.kind == wire::DatagramKind::kHello) {
    receive_hello(from, received);
    return;
  }
  if (header.kind != wire::DatagramKind::kData) {
    ++counters.bad_header;
    return;
  }
  const std::span<const std::uint8_t> body = received.subspan(wire::kHeaderBytes);
  Session* session = find(from, header.session);
  if (session == nullptr) {
    const HalfOpen* half = shutting_down ? nullptr : handshakes->find(from, header.session);
    if (half == nullptr) {
      ++counters.unknown_session;
      return;
    }
    session = open_keyed(HalfOpen(*half), header, body);
  }
  if (session != nullptr) receive_body(*session, header, body);
}

void Implementation::receive_hello(const Address& from, std::span<const std::uint8_t> received) {
  ++counters.hellos;
  const noise::Bytes answer =
      shutting_down ? noise::Bytes{} : handshakes->receive(from, received, now_ns);
  if (answer.empty()) {
    ++counters.hellos_dropped;
    return;
  }
  ++counters.sent;
  send(from, answer);
}

// The session of a handshake, when `body` is a DATA of it that opens: the client is there, and not
// only somebody who sends what it sent before.
Session* Implementation::open_keyed(const HalfOpen& half, const wire::DatagramHeader& header,
                                    std::span<const std::uint8_t> body) {
  const auto plain = half.transport.receive.open(header.counter, wire::encode_header(header), body);
  if (!plain.has_value()) {
    ++counters.forged;
    return nullptr;
  }
  v1::Packet packet;
  if (!wire::parse_packet(*plain, packet)) {
    ++counters.unreadable;
    return nullptr;
  }
  Session* session = open(half.address, half.session, half.role);
  if (session == nullptr) {
    refuse_full(half);
    handshakes->forget(half.session);
    return nullptr;
  }
  session->channel.secure(half.session, half.transport);
  handshakes->establish(half.session);
  return session;
}

// The only DATA of a session that there is no room for.
void Implementation::refuse_full(const HalfOpen& half) {
  wire::Channel channel(wire::Side::kServer, half.session);
  channel.secure(half.session, half.transport);
  v1::Packet packet;
  packet.set_boot_id(options.boot_id);
  packet.mutable_reset()->set_reason(v1::RESET_REASON_FULL);
  if (!channel.write(packet, now_ns, datagram)) return;
  ++counters.resets;
  ++counters.sent;
  send(half.address, {reinterpret_cast<const std::uint8_t*>(datagram.data()), datagram.size()});
}

}  // namespace hapticd
