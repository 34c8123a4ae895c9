// Counts heap calls per thread. Plain builds: this file defines malloc and its family in front of
// glibc's and forwards to glibc's own names; operator new calls malloc. Sanitizer builds own
// malloc, so their hooks count. Not RT.
#include "tests/support/no_heap.h"

#include <cerrno>
#include <cstddef>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define HAPTICD_MALLOC_HOOKS
#elif __has_feature(realtime_sanitizer)
#define HAPTICD_REALTIME_SANITIZER
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAPTICD_MALLOC_HOOKS
#endif

namespace {

// Initial-exec: reading it never allocates the thread's block, which malloc itself could not
// survive.
[[gnu::tls_model("initial-exec")]] constinit thread_local std::int64_t heap_calls = 0;

}  // namespace

namespace hapticd::test {

NoHeapScope::NoHeapScope() noexcept : start_(heap_calls) {}

std::int64_t NoHeapScope::count() const noexcept { return heap_calls - start_; }

}  // namespace hapticd::test

#ifdef HAPTICD_MALLOC_HOOKS

// Of <sanitizer/allocator_interface.h>, which gcc does not ship beside its sanitizers.
extern "C" int __sanitizer_install_malloc_and_free_hooks(
    void (*on_malloc)(const volatile void* block, std::size_t size),
    void (*on_free)(const volatile void* block));

namespace {

void on_malloc(const volatile void* /*block*/, std::size_t /*size*/) { ++heap_calls; }
void on_free(const volatile void* /*block*/) { ++heap_calls; }

[[maybe_unused]] const int installed =
    __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);

}  // namespace

#else

// The realtime sanitizer intercepts malloc too; its own functions report and forward.
#ifdef HAPTICD_REALTIME_SANITIZER
#define HAPTICD_NEXT(function) __interceptor_##function
#else
#define HAPTICD_NEXT(function) __libc_##function
#endif

extern "C" {

void* HAPTICD_NEXT(malloc)(std::size_t size);
void* HAPTICD_NEXT(calloc)(std::size_t count, std::size_t size);
void* HAPTICD_NEXT(realloc)(void* block, std::size_t size);
void* HAPTICD_NEXT(memalign)(std::size_t alignment, std::size_t size);
void HAPTICD_NEXT(free)(void* block);

void* malloc(std::size_t size) {
  ++heap_calls;
  return HAPTICD_NEXT(malloc)(size);
}

void* calloc(std::size_t count, std::size_t size) {
  ++heap_calls;
  return HAPTICD_NEXT(calloc)(count, size);
}

void* realloc(void* block, std::size_t size) {
  ++heap_calls;
  return HAPTICD_NEXT(realloc)(block, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
  ++heap_calls;
  return HAPTICD_NEXT(memalign)(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++heap_calls;
  return HAPTICD_NEXT(memalign)(alignment, size);
}

int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  ++heap_calls;
  *block = HAPTICD_NEXT(memalign)(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}

void free(void* block) {
  ++heap_calls;
  HAPTICD_NEXT(free)(block);
}

}  // extern "C"

#endif
