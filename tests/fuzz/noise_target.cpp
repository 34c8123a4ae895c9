// See noise_target.h.
#include "tests/fuzz/noise_target.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>

#include "proto/noise/handshake.h"
#include "proto/wire/channel.h"
#include "proto/wire/hello.h"
#include "server/network/protocol_server.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

using View = std::span<const std::uint8_t>;

constexpr std::int64_t kMs = 1'000'000;

void require(bool condition) {
  if (!condition) throw std::logic_error("the handshake did what it must not");
}

noise::Key key_of(std::uint8_t byte) {
  noise::Key key;
  key.fill(byte);
  return key;
}

bool equal(View a, View b) { return std::equal(a.begin(), a.end(), b.begin(), b.end()); }

constexpr auto kRole = wire::Role::kControl;

noise::Symmetric start() {
  return {key_of(2), wire::prologue_of(kRole, wire::Method::kNKpsk0),
          noise::public_half(key_of(3))};
}

noise::Handshake made_client() {
  return {noise::Side::kInitiator, start(), key_of(7), noise::public_half(key_of(3))};
}

noise::Bytes hello_of(View cookie, View message) {
  return wire::encode_hello({kRole, noise::key_id(key_of(2)), cookie, message},
                            noise::hello_key(key_of(2)));
}

/// `message` read where another one is awaited.
void check_reader(bool initiator, View message) {
  noise::Handshake client = made_client();
  noise::Handshake server(noise::Side::kResponder, start(), key_of(9), key_of(3));
  const noise::Bytes first = client.write().value();
  if (!initiator) {
    require(!server.read(message).has_value() || equal(message, first));
    if (equal(message, first)) return;
    require(server.read(first).has_value());
    return;
  }
  require(server.read(first).has_value());
  const noise::Bytes second = server.write().value();
  require(!client.read(message).has_value() || equal(message, second));
  if (!equal(message, second)) require(client.read(second).has_value());
  (void)client.split();
}

/// A server with keys, and one client that is shaking hands with it.
class KeyedServer {
 public:
  KeyedServer() : client_(made_client()), server_(options(), host(), sender()) {
    message_ = client_.write().value();
    receive(hello_of({}, message_));
    const auto cookie = wire::decode_retry(sent_);
    require(cookie.has_value());
    cookie_.assign(cookie->begin(), cookie->end());
  }

  /// Any datagram; whether it was answered.
  bool receive(View datagram) {
    const bool was_open = server_.session_count() != 0;
    in_ += datagram.size();
    sent_.clear();
    server_.receive(address_, datagram, now_ns_);
    now_ns_ += 100 * kMs;
    server_.poll(now_ns_);
    require(server_.session_count() <= 1);
    // Nobody but the client can open the session.
    require(was_open || open_ || server_.session_count() == 0);
    return !sent_.empty();
  }

  [[nodiscard]] const noise::Bytes& cookie() const { return cookie_; }

  /// The handshake goes on in spite of all that came.
  void shake_hands() {
    receive(hello_of(cookie_, message_));
    const auto welcome = wire::decode_welcome(sent_);
    require(welcome.has_value() && client_.read(welcome->message).has_value());
    session_ = welcome->session;
    transport_ = client_.split();
  }
  /// The body of a DATA of the session, sealed.
  bool receive_body(View body) {
    const auto header = wire::encode_header({wire::DatagramKind::kData, session_, counter_});
    noise::Bytes datagram(header.begin(), header.end());
    const noise::Bytes sealed = transport_->send.seal(counter_++, header, body);
    datagram.insert(datagram.end(), sealed.begin(), sealed.end());
    open_ = true;
    return receive(datagram);
  }

 private:
  static ServerOptions options() {
    const noise::ServerKeys keys = noise::server_keys(
        noise::SecretKey(key_of(3)), noise::SecretKey(key_of(1)), noise::SecretKey(key_of(2)));
    SplitMix64 random(5);
    return {.boot_id = 5, .keys = keys, .random = [random](std::span<std::uint8_t> all) mutable {
              for (std::uint8_t& byte : all) byte = static_cast<std::uint8_t>(random.next());
            }};
  }
  static ServerHost host() {
    ServerHost host;
    host.greeting = [] { return std::vector<v1::Item>(2); };
    host.request = [](const RequestId&, const v1::Item&) {};
    host.abandoned = [](const RequestId&) {};
    host.fill_state = [](const Subscription&, v1::State&) {};
    host.lease_lost = [](LeaseEnd) {};
    return host;
  }
  ProtocolServer::Send sender() {
    return [this](const Address&, View bytes) {
      const auto header = wire::decode_header(bytes);
      require(header.has_value());
      out_ += bytes.size();
      require(open_ || out_ <= in_);
      if (header->kind == wire::DatagramKind::kData) {
        require(open_ && header->session == session_);
        const auto plain =
            transport_->receive.open(header->counter, bytes.first(16), bytes.subspan(16));
        v1::Packet packet;
        require(plain.has_value() && wire::parse_packet(*plain, packet));
      } else {
        require(wire::decode_retry(bytes).has_value() || wire::decode_welcome(bytes).has_value());
      }
      sent_.assign(bytes.begin(), bytes.end());
    };
  }

  Address address_ = ipv4_address({10, 0, 0, 1}, 4);
  std::int64_t now_ns_ = 1000 * kMs;
  std::size_t in_ = 0;
  std::size_t out_ = 0;
  bool open_ = false;  ///< the client has sent DATA
  noise::Bytes sent_;
  noise::Handshake client_;
  noise::Bytes message_;
  noise::Bytes cookie_;
  std::uint32_t session_ = 0;
  std::uint64_t counter_ = 0;
  std::optional<noise::Transport> transport_;
  ProtocolServer server_;
};

bool check_server(unsigned how, View bytes) {
  KeyedServer server;
  noise::Bytes datagram(bytes.begin(), bytes.end());
  constexpr std::size_t kCookieAt = wire::kHeaderBytes + 2;
  if ((how & 4U) != 0 && datagram.size() >= kCookieAt + server.cookie().size()) {
    datagram[kCookieAt - 1] = static_cast<std::uint8_t>(server.cookie().size());
    std::copy(server.cookie().begin(), server.cookie().end(), datagram.begin() + kCookieAt);
  }
  const bool answered = (how & 8U) == 0 && server.receive(datagram);
  server.shake_hands();
  if ((how & 8U) == 0) {
    server.receive(datagram);
    v1::Packet packet;
    packet.set_first(1);
    const std::string body = packet.SerializeAsString();
    require(server.receive_body({reinterpret_cast<const std::uint8_t*>(body.data()), body.size()}));
    server.receive(datagram);
    return answered;
  }
  return server.receive_body(bytes.first(std::min(bytes.size(), wire::kPacketBytes)));
}

}  // namespace

bool check_noise_bytes(View bytes) {
  if (bytes.empty()) return false;
  const unsigned how = bytes[0];
  bytes = bytes.subspan(1);
  if ((how & 2U) != 0) return check_server(how, bytes);
  check_reader((how & 1U) != 0, bytes);
  return false;
}

}  // namespace hapticd::test
