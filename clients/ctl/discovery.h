// The daemons that are announced on the local network by mDNS (_hapticd._udp), as avahi-daemon
// knows them. What comes from the network is hostile: it is judged here. Not RT.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hapticd::ctl {

/// A daemon that is announced.
struct FoundDaemon {
  std::string name;     ///< whatever it calls itself, made printable
  std::string host;     ///< its name in the network, made printable
  std::string address;  ///< numeric; of IPv6 with its zone where it needs one
  std::uint16_t port = 0;
  bool keys = false;     ///< it hears only clients with a key
  std::string protocol;  ///< its version, digits; empty: not told

  friend auto operator<=>(const FoundDaemon&, const FoundDaemon&) = default;
};

/// `text` as a terminal may show it: its first 128 bytes, each that is not printable ASCII as '?'.
[[nodiscard]] std::string printable(std::string_view text);

/// ADDRESS:PORT as --server takes it.
[[nodiscard]] std::string server_text(const FoundDaemon& found);

/// All that are announced, each address once, in order; ends when avahi-daemon has told all that it
/// knows, at the latest after `patience`. Throws Failure(kRefused) with the remedy where there is
/// no avahi-daemon.
[[nodiscard]] std::vector<FoundDaemon> discover(std::chrono::nanoseconds patience);

}  // namespace hapticd::ctl
