// What the machine is asked for a thread that has to be on time: SCHED_FIFO, locked and prefaulted
// memory, one processor, absolute sleep. The haptic loop runs so, and the doctor measures so.
// Linux. sleep_until and thread_cpu_ns are RT, all else is for the start.
#pragma once

#include <cstddef>
#include <cstdint>
#include <thread>

namespace hapticd {

/// SCHED_FIFO priority of the loop; the guardian's is one above. Above interrupt threads (50),
/// below the kernel's own watchdogs (99).
inline constexpr int kLoopPriority = 80;

/// Stack touched before the first tick, bytes: all that the loop uses.
inline constexpr std::size_t kStackPrefault = std::size_t{512} * 1024;

/// Locks all memory, now and later. False, with errno, when refused.
bool lock_memory() noexcept;

/// Gives `thread` SCHED_FIFO at `priority`. False, with errno, when refused.
bool make_fifo(std::thread& thread, int priority) noexcept;

/// Keeps `thread` on processor `cpu`. False, with errno, when refused.
bool pin(std::thread& thread, std::uint32_t cpu) noexcept;

/// Names the calling thread, at most 15 characters, as top -H and a debugger show it.
void name_thread(const char* name) noexcept;

/// Touches the stack of the calling thread.
void prefault_stack() noexcept;

/// Sleeps until `t_ns` of the monotonic clock (monotonic_now_ns); at once when that has passed.
void sleep_until(std::int64_t t_ns) noexcept;

/// Processor time that the kernel has booked on the calling thread, ns. One system call.
[[nodiscard]] std::int64_t thread_cpu_ns() noexcept;

}  // namespace hapticd
