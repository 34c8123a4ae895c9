// See hello.h.
#include "proto/wire/hello.h"

#include <algorithm>

namespace hapticd::wire {
namespace {

/// Role and length of the cookie, bytes.
constexpr std::size_t kHelloHeadBytes = 2;

static_assert(kHeaderBytes + kHelloHeadBytes + kMaxCookieBytes + noise::kKeyIdBytes +
                  noise::kMessageBytes + noise::kHelloTagBytes <=
              kDatagramBytes);

/// The byte of a role under NNpsk0 is the role itself, under NKpsk0 this much more.
constexpr std::uint8_t kKnownServer = 2;

std::uint8_t role_byte(Role role, Method method) {
  const auto byte = static_cast<std::uint8_t>(role);
  return method == Method::kNNpsk0 ? byte : static_cast<std::uint8_t>(byte + kKnownServer);
}

/// The header, when the datagram is of `kind` and has counter 0.
std::optional<DatagramHeader> header_of(std::span<const std::uint8_t> datagram, DatagramKind kind) {
  const auto header = decode_header(datagram);
  if (!header.has_value() || header->kind != kind || header->counter != 0) return std::nullopt;
  return header;
}

std::vector<std::uint8_t> with_header(DatagramKind kind, std::uint32_t session,
                                      std::span<const std::uint8_t> body) {
  const auto header = encode_header({kind, session, 0});
  std::vector<std::uint8_t> datagram(header.size() + body.size());
  std::copy(body.begin(), body.end(), std::copy(header.begin(), header.end(), datagram.begin()));
  return datagram;
}

}  // namespace

std::array<std::uint8_t, 9> prologue_of(Role role, Method method) {
  return {'h', 'a', 'p', 't', 'i', 'c', 'd', kWireMajor, role_byte(role, method)};
}

std::vector<std::uint8_t> encode_hello(const HelloParts& parts, const noise::Key& hello_key) {
  std::vector<std::uint8_t> body{role_byte(parts.role, Method::kNKpsk0),
                                 static_cast<std::uint8_t>(parts.cookie.size())};
  body.insert(body.end(), parts.cookie.begin(), parts.cookie.end());
  body.insert(body.end(), parts.key_id.begin(), parts.key_id.end());
  body.insert(body.end(), parts.message.begin(), parts.message.end());
  std::vector<std::uint8_t> datagram = with_header(DatagramKind::kHello, 0, body);
  const noise::HelloTag tag = noise::hello_tag(hello_key, datagram);
  datagram.insert(datagram.end(), tag.begin(), tag.end());
  datagram.resize(kDatagramBytes);
  return datagram;
}

std::vector<std::uint8_t> encode_retry(std::span<const std::uint8_t> cookie) {
  return with_header(DatagramKind::kRetry, 0, cookie);
}

std::vector<std::uint8_t> encode_welcome(const Welcome& welcome) {
  return with_header(DatagramKind::kWelcome, welcome.session, welcome.message);
}

std::optional<Hello> decode_hello(std::span<const std::uint8_t> datagram) {
  const auto header = header_of(datagram, DatagramKind::kHello);
  if (!header.has_value() || header->session != 0 || datagram.size() != kDatagramBytes) {
    return std::nullopt;
  }
  const auto body = datagram.subspan(kHeaderBytes);
  const std::size_t cookie_bytes = body[1];
  if (body[0] < 1 || body[0] > 4 || cookie_bytes > kMaxCookieBytes) return std::nullopt;
  Hello hello;
  hello.method = body[0] <= kKnownServer ? Method::kNNpsk0 : Method::kNKpsk0;
  const bool known_server = hello.method == Method::kNKpsk0;
  hello.role = static_cast<Role>(body[0] - (known_server ? kKnownServer : 0));
  hello.cookie = body.subspan(kHelloHeadBytes, cookie_bytes);
  std::size_t at = kHelloHeadBytes + cookie_bytes;
  if (known_server) {
    hello.key_id = body.subspan(at, noise::kKeyIdBytes);
    at += noise::kKeyIdBytes;
  }
  hello.message = body.subspan(at, noise::kMessageBytes);
  at += noise::kMessageBytes;
  if (known_server) {
    hello.before = datagram.first(kHeaderBytes + at);
    hello.tag = body.subspan(at, noise::kHelloTagBytes);
  }
  return hello;
}

std::optional<std::span<const std::uint8_t>> decode_retry(std::span<const std::uint8_t> datagram) {
  const auto header = header_of(datagram, DatagramKind::kRetry);
  if (!header.has_value() || header->session != 0) return std::nullopt;
  const auto cookie = datagram.subspan(kHeaderBytes);
  if (cookie.empty() || cookie.size() > kMaxCookieBytes) return std::nullopt;
  return cookie;
}

std::optional<Welcome> decode_welcome(std::span<const std::uint8_t> datagram) {
  const auto header = header_of(datagram, DatagramKind::kWelcome);
  if (!header.has_value() || header->session == 0 ||
      datagram.size() != kHeaderBytes + noise::kMessageBytes) {
    return std::nullopt;
  }
  return Welcome{header->session, datagram.subspan(kHeaderBytes)};
}

}  // namespace hapticd::wire
