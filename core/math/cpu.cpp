// Asks the processor once, before main. Not RT, except through the header.
#include "core/math/cpu.h"

namespace hapticd {
namespace {

bool processor_has_avx2() noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

}  // namespace

std::atomic<bool> cpu_detail::use_avx2{processor_has_avx2()};

bool allow_avx2(bool allowed) noexcept {
  const bool use = allowed && processor_has_avx2();
  cpu_detail::use_avx2.store(use, std::memory_order_relaxed);
  return use;
}

}  // namespace hapticd
