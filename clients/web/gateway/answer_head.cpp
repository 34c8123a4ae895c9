// See answer_head.h.
#include "clients/web/gateway/answer_head.h"

namespace hapticd::web {
namespace {

constexpr std::size_t kLongestHost = 262;  ///< of a name, with its port

bool is_plain_host(std::string_view host) {
  constexpr std::string_view kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-.:[]";
  return !host.empty() && host.size() <= kLongestHost &&
         host.find_first_not_of(kLetters) == std::string_view::npos;
}

}  // namespace

std::string content_policy(std::string_view host) {
  std::string connect = "'self'";
  if (is_plain_host(host)) {
    connect += " ws://" + std::string(host) + " wss://" + std::string(host);
  }
  // The simplifier of meshes is WebAssembly; markers and plots are placed by styles of elements.
  return "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' "
         "'unsafe-inline'; img-src 'self' data:; font-src 'self'; manifest-src 'self'; "
         "connect-src " +
         connect + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

void guard(boost::beast::http::fields& head, std::string_view host) {
  head.set("Content-Security-Policy", content_policy(host));
  head.set("Cross-Origin-Opener-Policy", "same-origin");
  head.set("Cross-Origin-Resource-Policy", "same-origin");
  head.set("X-Content-Type-Options", "nosniff");
  head.set("X-Frame-Options", "DENY");
  // The token is behind the # of the address: browsers never send that, nor may the rest go.
  head.set("Referrer-Policy", "no-referrer");
}

}  // namespace hapticd::web
