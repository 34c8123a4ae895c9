// See access.h.
#include "clients/web/gateway/access.h"

#include <arpa/inet.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <stdexcept>

namespace hapticd::web {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return result;
}

/// Host without port and brackets, in small letters.
std::string name_of_host(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    return end == std::string_view::npos ? "" : lower(host.substr(1, end - 1));
  }
  return lower(host.substr(0, host.find(':')));
}

bool is_address(const std::string& name) {
  in_addr four{};
  in6_addr six{};
  return inet_pton(AF_INET, name.c_str(), &four) == 1 ||
         inet_pton(AF_INET6, name.c_str(), &six) == 1;
}

}  // namespace

std::string make_token() {
  std::array<std::uint8_t, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the system provides no random numbers");
  }
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string token;
  for (const std::uint8_t byte : bytes) {
    token += kDigits[byte >> 4U];
    token += kDigits[byte & 15U];
  }
  return token;
}

bool is_own_host(std::string_view host, const std::vector<std::string>& names) {
  const std::string name = name_of_host(host);
  if (is_address(name) || name == "localhost") return true;
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& own) { return lower(own) == name; });
}

bool may_look(std::string_view origin, std::string_view host, bool tls,
              const std::vector<std::string>& names) {
  if (!is_own_host(host, names)) return false;
  if (origin.empty()) return true;
  const std::string own = (tls ? "https://" : "http://") + lower(host);
  return lower(origin) == own;
}

std::string own_subprotocol(std::string_view offered) {
  while (!offered.empty()) {
    const std::size_t comma = offered.find(',');
    std::string_view one = offered.substr(0, comma);
    offered = comma == std::string_view::npos ? std::string_view{} : offered.substr(comma + 1);
    while (one.starts_with(' ')) one.remove_prefix(1);
    while (one.ends_with(' ')) one.remove_suffix(1);
    const bool bare = one == kSubprotocol;
    const bool with_token = one.starts_with(kSubprotocol) && one.size() > kSubprotocol.size() &&
                            one[kSubprotocol.size()] == '.';
    if (bare || with_token) return std::string(one);
  }
  return {};
}

bool carries_token(std::string_view subprotocol, std::string_view token) {
  if (token.empty() || subprotocol.size() != kSubprotocol.size() + 1 + token.size()) return false;
  const std::string_view given = subprotocol.substr(kSubprotocol.size() + 1);
  unsigned different = 0;
  for (std::size_t i = 0; i < token.size(); ++i) {
    different |= static_cast<unsigned char>(given[i] ^ token[i]);
  }
  return different == 0;
}

}  // namespace hapticd::web
