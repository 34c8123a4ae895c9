// What a thread of hapticd is for. Each says so as it begins, and may do from there on what its
// role needs and nothing else, if the program has given out means to see to that. RT: no, it is for
// the start of a thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace hapticd {

enum class ThreadRole : std::uint8_t {
  kHaptic,      ///< runs the loop
  kGuardian,    ///< watches the loop
  kStop,        ///< hears Stop, beside the network
  kWriter,      ///< writes to a device
  kAttachment,  ///< looks for devices that come and go
  kRecorder,    ///< writes recordings
  kBuilder,     ///< reads scenes
  kAnnouncer,   ///< tells the local network by mDNS
  kNetwork,     ///< the first thread, once it serves: peers and everything else
  kStart,       ///< the first thread before; a thread that a library makes then keeps it
};
inline constexpr std::size_t kThreadRoles = 10;

/// Confines the calling thread. May not throw.
using ConfineThread = void (*)(ThreadRole role) noexcept;

/// Set once, before the first thread begins; null: no thread is confined.
inline std::atomic<ConfineThread> confine_thread{nullptr};

/// The calling thread begins with its role: it has what it needs that the role does not let it get.
/// A thread that it makes has no more than its own role lets it.
inline void begin_role(ThreadRole role) noexcept {
  const ConfineThread confine = confine_thread.load(std::memory_order_acquire);
  if (confine != nullptr) confine(role);
}

}  // namespace hapticd
