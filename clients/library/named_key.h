// The key that a command line names, by --key and --role. Not RT.
#pragma once

#include <optional>
#include <string>

#include "clients/library/key_handshake.h"

namespace hapticd::client {

/// The key in `file`; none where that is empty. `role`: view or control; empty: its own.
/// Throws as read_client_key() does, and std::invalid_argument for another role.
[[nodiscard]] std::optional<ClientKey> named_key(const std::string& file,
                                                 const std::string& role = "");

}  // namespace hapticd::client
