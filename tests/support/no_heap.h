// Proof that code does not touch the heap: counts every allocation and release (malloc family,
// operator new and delete) that the calling thread makes inside a scope. Without a sanitizer the
// executable's own malloc counts; under ASan and TSan their hooks do. Make the checks of the test
// framework after the scope: they allocate.
//
//   NoHeapScope scope;
//   simulation.step(input, output);
//   const std::int64_t touched = scope.count();
//   CHECK(touched == 0);
#pragma once

#include <cstdint>

namespace hapticd::test {

class NoHeapScope {
 public:
  /// Starts counting on this thread. Scopes may nest; each counts all that happens while it lives.
  NoHeapScope() noexcept;

  /// Heap calls of this thread since the construction.
  [[nodiscard]] std::int64_t count() const noexcept;

 private:
  std::int64_t start_;
};

}  // namespace hapticd::test
