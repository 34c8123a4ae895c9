// Which instruction set the hand-written loops use: every one of them exists twice, for the x86-64
// baseline and for AVX2, with equal bits; this is the one place that chooses. RT: avx2_available
// is a relaxed load; the choice is made before main.
#pragma once

#include <atomic>

namespace hapticd {

namespace cpu_detail {
extern std::atomic<bool> use_avx2;
}

/// True when loops may use AVX2: the processor and the system have it and no test forbade it.
/// False until the static initialisation of core/math has run, which costs speed, never bits.
[[nodiscard]] inline bool avx2_available() noexcept {
  return cpu_detail::use_avx2.load(std::memory_order_relaxed);
}

/// For tests of equal bits: false forces the baseline loops, true returns to what the processor
/// has. Process-wide. Returns the new value of avx2_available().
bool allow_avx2(bool allowed) noexcept;

}  // namespace hapticd
