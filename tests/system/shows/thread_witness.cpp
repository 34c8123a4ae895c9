// Preloaded into a hapticd under test: counts what the thread named "haptic" takes from the
// allocator, from locks and from the scheduler between its first sleep and its last, and writes
// one JSON object into the file $HAPTICD_WITNESS when the daemon ends. Not RT.
#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/resource.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

extern "C" {
// What the C library itself calls behind the names that are taken here.
void* system_malloc(std::size_t size) __asm__("__libc_malloc");
void* system_calloc(std::size_t count, std::size_t size) __asm__("__libc_calloc");
void* system_realloc(void* place, std::size_t size) __asm__("__libc_realloc");
void* system_memalign(std::size_t alignment, std::size_t size) __asm__("__libc_memalign");
void system_free(void* place) __asm__("__libc_free");
}

namespace {

/// What one thread has taken.
struct Taken {
  std::uint64_t allocations = 0;  ///< malloc and its kin, free included
  std::uint64_t locks = 0;        ///< mutexes, conditions, semaphores: taken, tried or waited for
};

thread_local Taken taken __attribute__((tls_model("initial-exec")));
std::atomic<std::uint64_t> all_allocations{0}, all_locks{0};

/// The haptic thread's, from its first sleep to its latest.
struct Report {
  std::atomic<std::uint64_t> ticks{0}, allocations{0}, locks{0}, waits{0}, page_faults{0};
} report;

void allocation() {
  ++taken.allocations;
  all_allocations.fetch_add(1, std::memory_order_relaxed);
}

void lock() {
  ++taken.locks;
  all_locks.fetch_add(1, std::memory_order_relaxed);
}

/// The function of this name that the preloaded one stands before.
template <typename Function>
Function* behind(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool is_haptic() {
  char name[16] = "";
  pthread_getname_np(pthread_self(), name, sizeof(name));
  return std::strcmp(name, "haptic") == 0;
}

/// Called by the haptic thread before each of its sleeps.
void note_sleep() {
  static Taken first;
  static rusage first_usage;
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  if (report.ticks == 0) first = taken, first_usage = usage;
  report.ticks.fetch_add(1);
  report.allocations = taken.allocations - first.allocations;
  report.locks = taken.locks - first.locks;
  report.waits = static_cast<std::uint64_t>(usage.ru_nvcsw - first_usage.ru_nvcsw);
  report.page_faults = static_cast<std::uint64_t>(usage.ru_minflt + usage.ru_majflt -
                                                  first_usage.ru_minflt - first_usage.ru_majflt);
}

[[gnu::destructor]] void write_report() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): the process ends, its threads have
  const char* path = std::getenv("HAPTICD_WITNESS");
  std::FILE* file = path != nullptr ? std::fopen(path, "w") : nullptr;
  if (file == nullptr) return;
  const auto number = [](const std::atomic<std::uint64_t>& value) {
    return static_cast<unsigned long long>(value.load());
  };
  std::fprintf(file,
               "{\"ticks\": %llu, \"allocations\": %llu, \"locks\": %llu, \"waits\": %llu, "
               "\"page_faults\": %llu, \"all_allocations\": %llu, \"all_locks\": %llu}\n",
               number(report.ticks), number(report.allocations), number(report.locks),
               number(report.waits), number(report.page_faults), number(all_allocations),
               number(all_locks));
  std::fclose(file);
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) noexcept {
  allocation();
  return system_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  allocation();
  return system_calloc(count, size);
}

void* realloc(void* place, std::size_t size) noexcept {
  allocation();
  return system_realloc(place, size);
}

void* memalign(std::size_t alignment, std::size_t size) noexcept {
  allocation();
  return system_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  allocation();
  return system_memalign(alignment, size);
}

int posix_memalign(void** out, std::size_t alignment, std::size_t size) noexcept {
  allocation();
  *out = system_memalign(alignment, size);
  return *out != nullptr ? 0 : 12;
}

void free(void* place) noexcept {
  allocation();
  system_free(place);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static auto* const function = behind<int(pthread_mutex_t*)>("pthread_mutex_lock");
  lock();
  return function(mutex);
}

int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  static auto* const function = behind<int(pthread_mutex_t*)>("pthread_mutex_trylock");
  lock();
  return function(mutex);
}

int pthread_rwlock_rdlock(pthread_rwlock_t* mutex) noexcept {
  static auto* const function = behind<int(pthread_rwlock_t*)>("pthread_rwlock_rdlock");
  lock();
  return function(mutex);
}

int pthread_rwlock_wrlock(pthread_rwlock_t* mutex) noexcept {
  static auto* const function = behind<int(pthread_rwlock_t*)>("pthread_rwlock_wrlock");
  lock();
  return function(mutex);
}

int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  static auto* const function = behind<int(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  lock();
  return function(condition, mutex);
}

int pthread_cond_signal(pthread_cond_t* condition) noexcept {
  static auto* const function = behind<int(pthread_cond_t*)>("pthread_cond_signal");
  lock();
  return function(condition);
}

int sem_wait(sem_t* semaphore) {
  static auto* const function = behind<int(sem_t*)>("sem_wait");
  lock();
  return function(semaphore);
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* until, timespec* left) {
  static auto* const function =
      behind<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  thread_local const bool haptic __attribute__((tls_model("initial-exec"))) = is_haptic();
  if (haptic) note_sleep();
  return function(clock, flags, until, left);
}

}  // extern "C"
