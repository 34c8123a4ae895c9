// HELLO, RETRY and WELCOME, the datagrams of the handshake of keyed sessions: PROTOCOL.md, section
// 12. Layout alone; what is in them is of proto/noise and of either side. Pure. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/noise/handshake.h"
#include "proto/noise/hello_tag.h"
#include "proto/noise/key_file.h"
#include "proto/wire/datagram.h"

namespace hapticd::wire {

/// Longest cookie, bytes.
inline constexpr std::size_t kMaxCookieBytes = 64;

using noise::Role;

/// How hands are shaken: the protocol of Noise.
enum class Method : std::uint8_t {
  kNNpsk0,  ///< of 0.1: a server proves no more than that it has the psk
  kNKpsk0,  ///< a server proves that it has the private half of its own key
};

/// What a HELLO says. The spans are views of the datagram.
struct Hello {
  Role role = Role::kView;
  Method method = Method::kNKpsk0;
  std::span<const std::uint8_t> cookie;   ///< [0, 64] bytes
  std::span<const std::uint8_t> key_id;   ///< 8 bytes, noise::key_id(); NNpsk0: none
  std::span<const std::uint8_t> message;  ///< 48 bytes
  std::span<const std::uint8_t> before;   ///< all of the datagram before the tag; NNpsk0: none
  std::span<const std::uint8_t> tag;      ///< 16 bytes, noise::hello_tag(); NNpsk0: none
};

/// What a HELLO of NKpsk0 is made of.
struct HelloParts {
  Role role = Role::kView;
  noise::KeyId key_id{};
  std::span<const std::uint8_t> cookie;   ///< [0, 64] bytes
  std::span<const std::uint8_t> message;  ///< 48 bytes
};

struct Welcome {
  std::uint32_t session = 0;
  std::span<const std::uint8_t> message;  ///< 48 bytes
};

/// What the handshake of `role` hashes first.
[[nodiscard]] std::array<std::uint8_t, 9> prologue_of(Role role, Method method);

/// The 1200 bytes of a HELLO of NKpsk0, with its tag under `hello_key`, noise::hello_key().
[[nodiscard]] std::vector<std::uint8_t> encode_hello(const HelloParts& parts,
                                                     const noise::Key& hello_key);
/// A RETRY with this cookie, [1, 64] bytes.
[[nodiscard]] std::vector<std::uint8_t> encode_retry(std::span<const std::uint8_t> cookie);
[[nodiscard]] std::vector<std::uint8_t> encode_welcome(const Welcome& welcome);

/// The HELLO of either method in a datagram; nothing when it is none, or not 1200 bytes long, or
/// has a session, a counter, an unknown role, or a cookie longer than 64 bytes.
[[nodiscard]] std::optional<Hello> decode_hello(std::span<const std::uint8_t> datagram);
/// The cookie of a RETRY; nothing when it is none, or not [1, 64] bytes long.
[[nodiscard]] std::optional<std::span<const std::uint8_t>> decode_retry(
    std::span<const std::uint8_t> datagram);
/// The WELCOME in a datagram; nothing when it is none, of another length, or of session 0.
[[nodiscard]] std::optional<Welcome> decode_welcome(std::span<const std::uint8_t> datagram);

}  // namespace hapticd::wire
