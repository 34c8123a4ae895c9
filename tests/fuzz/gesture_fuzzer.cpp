// libFuzzer's entry to gesture_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/gesture_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_gesture_bytes({data, size});
  return 0;
}
