// The folder of a daemon's keys: server.key, the daemon's own, which never leaves it; view.key and
// control.key for clients; stop.key for its Stop road; and in clients/NAME.key one of each client
// that has its own. PROTOCOL.md, sections 12 and 17. Not RT.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/noise/key_file.h"

namespace hapticd::noise {

inline constexpr const char* kServerKeyName = "server.key";
inline constexpr const char* kViewKeyName = "view.key";
inline constexpr const char* kControlKeyName = "control.key";
inline constexpr const char* kStopKeyName = "stop.key";

/// A key that opens sessions, as the daemon knows it.
struct KnownKey {
  std::string name;  ///< of its client; empty: view.key or control.key
  Role role = Role::kView;
  SecretKey psk{};
};

/// The keys by which a daemon knows its clients, and they know it.
struct ServerKeys {
  SecretKey own{};              ///< the private half of its own key
  Key server{};                 ///< the public half
  std::vector<KnownKey> known;  ///< view.key and control.key first
};

/// Those of a daemon without keys of clients.
[[nodiscard]] ServerKeys server_keys(const SecretKey& own, const SecretKey& view,
                                     const SecretKey& control);

/// The keys in `folder`. Throws std::runtime_error with the file and the remedy: one cannot be
/// read, is none, an old one or of another daemon, others may access it, or view.key and
/// control.key are equal, so that whoever may look could control.
[[nodiscard]] ServerKeys read_key_folder(const std::filesystem::path& folder);

/// Makes `folder` if need be, and four random keys in it. Where view.key and control.key are there,
/// what is missing beside them is made, and files of an earlier version get the daemon's public
/// half and keep their psk. Throws std::runtime_error with the reason and the remedy; no key that
/// is there is lost.
void make_key_folder(const std::filesystem::path& folder);

}  // namespace hapticd::noise
