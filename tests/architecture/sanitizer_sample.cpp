// Commits the fault named by its argument, so that a sanitizer preset can be seen to report it:
// address, undefined, thread or realtime. Its test passes when the report appears.
#include <climits>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "core/math/realtime.h"

namespace {

volatile int shared_number = 0;
void* volatile shared_block = nullptr;

void overrun_heap() {
  auto* const volatile numbers = new int[4];
  shared_number = numbers[4];
  delete[] numbers;
}

void overflow_integer() {
  shared_number = INT_MAX;
  shared_number = shared_number + 1;
}

void race() {
  std::thread other([] { shared_number = 1; });
  shared_number = 2;
  other.join();
}

void allocate_in_realtime() noexcept HD_REALTIME { shared_block = std::malloc(8); }

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  if (std::strcmp(arguments[1], "address") == 0) overrun_heap();
  if (std::strcmp(arguments[1], "undefined") == 0) overflow_integer();
  if (std::strcmp(arguments[1], "thread") == 0) race();
  if (std::strcmp(arguments[1], "realtime") == 0) allocate_in_realtime();
  return 0;
}
