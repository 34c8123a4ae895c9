// Where a thread that may ask for memory goes on without it. All threads but the haptic one and its
// guardian ask for memory; what one of them begins for a peer runs inside a boundary, so that a
// shortage costs that piece of work and never the process. Not RT.
#pragma once

#include <atomic>
#include <cstdint>
#include <new>

namespace hapticd {

/// Pieces of work of this process that were left undone for want of memory.
inline std::atomic<std::uint64_t> shortages_of_memory{0};

/// Runs `work()`. False where memory was short: counted, and what it had begun stays as its
/// exceptions leave it, which whoever calls this has to mend. Other exceptions pass. Nothing here
/// asks for memory.
template <typename Work>
bool within_memory(Work&& work) {
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
    shortages_of_memory.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
}

}  // namespace hapticd
