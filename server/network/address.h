// Where a datagram came from: an IP address and a port as plain bytes, so that sessions can be kept
// and compared without a socket. Not RT.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>

namespace hapticd {

/// IP address and UDP port. IPv4 addresses are in their IPv6-mapped form ::ffff:a.b.c.d.
struct Address {
  std::array<std::uint8_t, 16> ip{};
  std::uint16_t port = 0;  ///< host byte order

  friend auto operator<=>(const Address&, const Address&) = default;
};

/// a.b.c.d:port in Address's form.
[[nodiscard]] constexpr Address ipv4_address(std::array<std::uint8_t, 4> ip,
                                             std::uint16_t port) noexcept {
  Address address;
  address.ip[10] = 0xff;
  address.ip[11] = 0xff;
  for (std::size_t i = 0; i < 4; ++i) address.ip[12 + i] = ip[i];
  address.port = port;
  return address;
}

/// Whether it is an IPv4 address.
[[nodiscard]] constexpr bool is_ipv4(const Address& address) noexcept {
  const auto mapped = ipv4_address({}, 0).ip;
  return std::equal(mapped.begin(), mapped.begin() + 12, address.ip.begin());
}

/// What counts as one address where addresses share something: all of an IPv4 address, the network
/// of 64 bits of an IPv6 one. A view of `address`.
[[nodiscard]] constexpr std::span<const std::uint8_t> network_of(const Address& address) noexcept {
  const std::span<const std::uint8_t> whole = address.ip;
  return is_ipv4(address) ? whole : whole.first(8);
}

/// Whether they count as one address.
[[nodiscard]] constexpr bool same_network(const Address& a, const Address& b) noexcept {
  return std::ranges::equal(network_of(a), network_of(b));
}

/// Whether it is of this machine alone: 127.0.0.0/8 or ::1.
[[nodiscard]] constexpr bool is_loopback(const Address& address) noexcept {
  if (is_ipv4(address)) return address.ip[12] == 127;
  return std::all_of(address.ip.begin(), address.ip.end() - 1, [](auto b) { return b == 0; }) &&
         address.ip[15] == 1;
}

/// A hash of address and port, the same on every machine. Not secret: only for tables whose
/// collisions cost little.
[[nodiscard]] constexpr std::uint64_t hash_of(const Address& address) noexcept {
  constexpr std::uint64_t kPrime = 0x100000001b3U;  // FNV-1a
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const std::uint8_t byte : address.ip) hash = (hash ^ byte) * kPrime;
  hash = (hash ^ (address.port & 0xffU)) * kPrime;
  return (hash ^ (address.port >> 8U)) * kPrime;
}

}  // namespace hapticd
