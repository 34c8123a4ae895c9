// libFuzzer's entry to spacemouse_target.h.
#include "tests/fuzz/spacemouse_target.h"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_spacemouse_bytes({data, size});
  return 0;
}
