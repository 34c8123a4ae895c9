// libFuzzer's entry to noise_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/noise_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_noise_bytes({data, size});
  return 0;
}
