// Who may look and who may control, by what the head of a handshake says. A browser names the page
// that opens a WebSocket (Origin) and the address it believes to speak to (Host): both have to be
// ours, or a page of elsewhere could use this browser, also by a name that it points at us. Pure
// but for the random token. Not RT.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hapticd::web {

/// What a WebSocket of the stream is called, and what leads its token.
inline constexpr std::string_view kSubprotocol = "hapticd.v1";

/// 32 letters and digits out of 128 random bits. Throws std::runtime_error where the system has
/// none.
[[nodiscard]] std::string make_token();

/// Whether `host`, of the head Host, with or without port, is this machine by a name that nobody
/// else can give it: an IP address, localhost, or one of `names`.
[[nodiscard]] bool is_own_host(std::string_view host, const std::vector<std::string>& names);

/// Whether a page of `origin` may open a WebSocket at `host`. What is not a browser has no origin.
[[nodiscard]] bool may_look(std::string_view origin, std::string_view host, bool tls,
                            const std::vector<std::string>& names);

/// The first of the subprotocols, divided by commas, that is ours, with or without token; else
/// empty.
[[nodiscard]] std::string own_subprotocol(std::string_view offered);

/// Whether `subprotocol` carries `token`; takes as long for every one of its length. An empty token
/// is carried by none.
[[nodiscard]] bool carries_token(std::string_view subprotocol, std::string_view token);

}  // namespace hapticd::web
