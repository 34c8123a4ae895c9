// Preloaded into a program: from SIGUSR1 to SIGUSR2 its operator new fails, at random, on all
// threads but the haptic one and its guardian, which may not ask at all. Of the environment:
// FAILING_MEMORY_SEED, and FAILING_MEMORY_ONE_IN, the mean number of allocations per failure.
#include <pthread.h>
#include <signal.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

std::atomic<bool> failing{false};
std::atomic<std::uint64_t> dice{1};
std::uint64_t one_in = 100;

void on_signal(int signal) { failing.store(signal == SIGUSR1); }

std::uint64_t number_of(const char* name, std::uint64_t otherwise) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): before main
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

__attribute__((constructor)) void begin() {
  dice.store(number_of("FAILING_MEMORY_SEED", 1));
  one_in = number_of("FAILING_MEMORY_ONE_IN", one_in);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGUSR1, &action, nullptr);
  sigaction(SIGUSR2, &action, nullptr);
}

bool on_time() {
  char name[16] = "";
  pthread_getname_np(pthread_self(), name, sizeof(name));
  return std::strcmp(name, "haptic") == 0 || std::strcmp(name, "guardian") == 0;
}

/// Of splitmix64.
bool fails() {
  if (!failing.load(std::memory_order_relaxed) || on_time()) return false;
  std::uint64_t x = dice.fetch_add(0x9e3779b97f4a7c15U);
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return (x ^ (x >> 31U)) % one_in == 0;
}

void* memory(std::size_t bytes) { return fails() ? nullptr : std::malloc(bytes); }

void* aligned(std::size_t bytes, std::align_val_t alignment) {
  const auto unit = static_cast<std::size_t>(alignment);
  return fails() ? nullptr : std::aligned_alloc(unit, (bytes + unit - 1) / unit * unit);
}

void* or_throw(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) { return or_throw(memory(bytes)); }
void* operator new[](std::size_t bytes) { return or_throw(memory(bytes)); }
void* operator new(std::size_t bytes, const std::nothrow_t& /*unused*/) noexcept {
  return memory(bytes);
}
void* operator new[](std::size_t bytes, const std::nothrow_t& /*unused*/) noexcept {
  return memory(bytes);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return or_throw(aligned(bytes, alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment) {
  return or_throw(aligned(bytes, alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*bytes*/) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t /*bytes*/) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t /*unit*/) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t /*unit*/) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
