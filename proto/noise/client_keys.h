// Keys of single clients, clients/NAME.key in the folder of a daemon's keys: made, listed, revoked
// by being removed, and read by the daemon while it runs. PROTOCOL.md, section 12. Not RT.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "proto/noise/key_folder.h"

namespace hapticd::noise {

inline constexpr const char* kClientFolderName = "clients";
/// Keys of clients that a daemon knows at a time.
inline constexpr std::size_t kMaxClientKeys = 64;

/// Whether it may be the name of a client: 1 to 64 of a-z, 0-9, '_' and '-'.
[[nodiscard]] bool is_client_name(std::string_view name) noexcept;

/// Where the key of a client is.
[[nodiscard]] std::filesystem::path client_key_file(const std::filesystem::path& folder,
                                                    const std::string& name);

/// Makes the key of one client; its file. Throws std::runtime_error with the reason and the remedy:
/// the name is none or taken, there are as many as a daemon knows, or `folder` is none of keys.
std::filesystem::path make_client_key(const std::filesystem::path& folder, const std::string& name,
                                      Role role);

/// Removes the key of one client: a daemon that runs ends its sessions. Throws std::runtime_error
/// with the reason: there is none, or it cannot be removed.
void revoke_client_key(const std::filesystem::path& folder, const std::string& name);

/// The keys of clients, and what is wrong with files that are none, one sentence each.
struct ClientKeys {
  std::vector<KnownKey> known;  ///< in the order of their names, at most 64
  std::vector<std::string> problems;
};

/// Those of `folder`, which has `keys` without those of clients. A file that cannot be used is a
/// problem and no more; no folder of clients: no keys.
[[nodiscard]] ClientKeys read_client_keys(const std::filesystem::path& folder,
                                          const ServerKeys& keys);

}  // namespace hapticd::noise
