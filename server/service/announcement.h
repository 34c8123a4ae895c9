// The daemon's name on the local network, by mDNS: a service _hapticd._udp that avahi-daemon
// publishes, with a thread of libavahi that does nothing else. Not RT.
#pragma once

#include <cstdint>
#include <memory>

namespace hapticd {

/// Of the service, as clients browse for it.
inline constexpr const char* kServiceType = "_hapticd._udp";

/// What is announced.
struct Announced {
  std::uint16_t port = 0;
  std::uint32_t protocol = 0;  ///< version of the protocol spoken there
  bool ipv4_only = false;      ///< else IPv6 too
};

/// Published for as long as this lives.
class Announcement {
 public:
  /// Publishes "hapticd on HOST", with protocol=VERSION and keys=required in its TXT record. Where
  /// avahi-daemon does not run, the log says so, and it is published once it does; a name that is
  /// taken gets a number. Does not throw for what the network or avahi-daemon do.
  explicit Announcement(const Announced& what);
  Announcement(const Announcement&) = delete;
  Announcement& operator=(const Announcement&) = delete;
  ~Announcement();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace hapticd
