// What stands in the head of every answer of the gateway, so that a browser does with it what it is
// meant for and nothing else. Pure. Not RT.
#pragma once

#include <boost/beast/http/fields.hpp>
#include <string>
#include <string_view>

namespace hapticd::web {

/// The Content-Security-Policy of an answer to who asked for it under this Host: scripts, styles
/// and connections are the gateway's own, and nobody frames it. Old browsers do not count a
/// WebSocket of the same host as their own, so it is named, unless `host` has other letters than
/// hosts have.
[[nodiscard]] std::string content_policy(std::string_view host);

/// Puts into `head` what keeps the answer what it is: policy, nosniff, no frames, no opener, no
/// referrer, for the own origin alone.
void guard(boost::beast::http::fields& head, std::string_view host);

}  // namespace hapticd::web
