// The socket that systemd has bound for the daemon (sd_listen_fds(3)): hapticd.socket. Not RT.
#pragma once

#include <optional>

namespace hapticd {

/// The descriptor of the socket; none where none was passed. Takes $LISTEN_FDS and its like out of
/// the environment. Throws std::runtime_error with what is wrong and the remedy: more than one was
/// passed, or it is no bound UDP socket.
[[nodiscard]] std::optional<int> passed_socket();

}  // namespace hapticd
