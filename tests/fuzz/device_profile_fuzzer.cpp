// libFuzzer's entry to device_profile_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/device_profile_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_device_profile_bytes({data, size});
  return 0;
}
