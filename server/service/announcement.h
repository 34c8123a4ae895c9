// The daemon's name on the local network, by mDNS: a service _hapticd._udp that avahi-daemon
// publishes, with a thread that does nothing else. Not RT.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <thread>

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
  /// taken gets a number. Does not throw for what the network or avahi-daemon do,
  /// nor wait for them.
  explicit Announcement(const Announced& what);
  Announcement(const Announcement&) = delete;
  Announcement& operator=(const Announcement&) = delete;
  /// Withdrawn; waits for avahi-daemon for at most 0.2 s. One that hangs withdraws it when the
  /// process ends.
  ~Announcement();

  /// Begins to withdraw it, without waiting.
  void withdraw() noexcept;

 private:
  struct Implementation;
  std::shared_ptr<Implementation> implementation_;  ///< shared with the thread, which may outlive
  std::future<void> finished_;                      ///< of the thread
  std::thread thread_;
};

}  // namespace hapticd
