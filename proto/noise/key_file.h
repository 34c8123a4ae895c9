// The file of a key: what a client needs to open sessions of one daemon. 72 bytes, readable by its
// owner alone: "hapticd", the role, the psk, and the public half of the daemon's own key, by which
// the client knows the daemon. stop.key is 32 random bytes and nothing else. PROTOCOL.md, sections
// 12 and 17. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "proto/noise/handshake.h"
#include "proto/noise/locked.h"

namespace hapticd::noise {

/// Whose key it is: what its holder may do.
enum class Role : std::uint8_t {
  kView = 1,     ///< look and listen
  kControl = 2,  ///< and control
};

/// A key that is wiped when it goes.
using SecretKey = Locked<Key>;

/// Size of a key file, bytes; that of one of 0.1, which names no daemon, and of
/// stop.key.
inline constexpr std::size_t kKeyFileBytes = 7 + 1 + 2 * kKeyBytes;
inline constexpr std::size_t kBareKeyBytes = kKeyBytes;

/// What is in a key file.
struct SessionKey {
  Role role = Role::kControl;
  SecretKey psk{};
  Key server{};  ///< public half of the daemon's own key
};

/// The key in `file`. Throws std::runtime_error with the file and the remedy: it cannot be read, is
/// no key file or an old one, or users other than its owner may access it.
[[nodiscard]] SessionKey read_session_key(const std::filesystem::path& file);

/// Writes a new key file. Throws std::runtime_error with the file and the remedy: it is there, or
/// cannot be written.
void write_session_key(const std::filesystem::path& file, const SessionKey& key);

/// The same in place of an old one.
void replace_session_key(const std::filesystem::path& file, const SessionKey& key);

/// The 32 bytes in `file`, that of a Stop road or of a daemon itself. Throws as read_session_key()
/// does.
[[nodiscard]] SecretKey read_bare_key(const std::filesystem::path& file);

/// Writes a new file with these 32 bytes. Throws as write_session_key() does.
void write_bare_key(const std::filesystem::path& file, const SecretKey& key);

/// 32 random bytes.
[[nodiscard]] SecretKey random_key();

}  // namespace hapticd::noise
