// The way out of a failed assertion: one thread runs the handler, once, then the process aborts.
// RT: terminal, so system calls are allowed here and nowhere else; no heap, no lock, no formatting
// library.
#include "core/math/assert.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace hapticd {
namespace {

void write_to_stderr(const char* text, std::size_t size) noexcept {
  // Nothing is left to be done about a failed write.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, size);
}

void write_to_stderr(const char* text) noexcept { write_to_stderr(text, std::strlen(text)); }

/// "file:line: assertion failed: condition" on stderr.
void report_on_stderr(const char* condition, const char* file, int line) noexcept {
  std::array<char, 16> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), line).ptr;
  write_to_stderr(file);
  write_to_stderr(":");
  write_to_stderr(digits.data(), static_cast<std::size_t>(end - digits.data()));
  write_to_stderr(": assertion failed: ");
  write_to_stderr(condition);
  write_to_stderr("\n");
}

constinit std::atomic<AssertionHandler> active_handler{report_on_stderr};
constinit std::atomic<bool> any_thread_failing{false};
/// Aligned for the linker alone: mold 1.10 begins what becomes read-only with a thread's variables,
/// and a byte just before the end of a page, where nothing is mapped, keeps a program from
/// starting.
alignas(64) constinit thread_local bool this_thread_failing = false;

}  // namespace

void set_assertion_handler(AssertionHandler handler) noexcept {
  active_handler.store(handler != nullptr ? handler : report_on_stderr);
}

void fail_assertion(const char* condition, const char* file, int line) noexcept {
  // A handler that fails itself must not run again.
  if (this_thread_failing) std::abort();
  this_thread_failing = true;

  // A second thread waits for the first one's abort: aborting now would cut its handler, and the
  // zero wrench, short.
  if (any_thread_failing.exchange(true)) {
    for (;;) ::pause();
  }
  active_handler.load()(condition, file, line);
  std::abort();
}

}  // namespace hapticd
