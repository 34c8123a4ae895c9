// Assertions for programmer errors. A failed assertion is a bug of ours, never a reaction to input:
// it calls the emergency handler (the daemon registers one that writes a zero wrench to the device)
// and aborts. On in every build type, so keep conditions O(1). RT: yes; no heap, no lock, the
// message is written by the handler's own means.
#pragma once

namespace hapticd {

/// Called once with the failed condition and its place before the process aborts. Must not return
/// to the caller's work, allocate or throw; it may write a zero wrench and a message.
using AssertionHandler = void (*)(const char* condition, const char* file, int line) noexcept;

/// Installs `handler` for the whole process; nullptr restores the default (message on stderr).
/// Thread-safe, lock-free.
void set_assertion_handler(AssertionHandler handler) noexcept;

/// Runs the handler, then aborts. Use through HD_ASSERT.
[[noreturn]] void fail_assertion(const char* condition, const char* file, int line) noexcept;

}  // namespace hapticd

/// Aborts through fail_assertion when `condition` is false.
#define HD_ASSERT(condition)                           \
  (static_cast<bool>(condition) ? static_cast<void>(0) \
                                : ::hapticd::fail_assertion(#condition, __FILE__, __LINE__))
