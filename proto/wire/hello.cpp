// See hello.h.
#include "proto/wire/hello.h"

#include <algorithm>

namespace hapticd::wire {
namespace {

/// Role and length of the cookie, bytes.
constexpr std::size_t kHelloHeadBytes = 2;

static_assert(kHeaderBytes + kHelloHeadBytes + kMaxCookieBytes + noise::kMessageBytes <=
              kDatagramBytes);

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

std::array<std::uint8_t, 9> prologue_of(Role role) {
  return {'h', 'a', 'p', 't', 'i', 'c', 'd', kWireMajor, static_cast<std::uint8_t>(role)};
}

std::vector<std::uint8_t> encode_hello(const Hello& hello) {
  std::vector<std::uint8_t> body{static_cast<std::uint8_t>(hello.role),
                                 static_cast<std::uint8_t>(hello.cookie.size())};
  body.insert(body.end(), hello.cookie.begin(), hello.cookie.end());
  body.insert(body.end(), hello.message.begin(), hello.message.end());
  body.resize(kDatagramBytes - kHeaderBytes);
  return with_header(DatagramKind::kHello, 0, body);
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
  const bool known = body[0] == static_cast<std::uint8_t>(Role::kView) ||
                     body[0] == static_cast<std::uint8_t>(Role::kControl);
  const std::size_t cookie_bytes = body[1];
  if (!known || cookie_bytes > kMaxCookieBytes) return std::nullopt;
  Hello hello;
  hello.role = static_cast<Role>(body[0]);
  hello.cookie = body.subspan(kHelloHeadBytes, cookie_bytes);
  hello.message = body.subspan(kHelloHeadBytes + cookie_bytes, noise::kMessageBytes);
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
