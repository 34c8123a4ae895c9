// libFuzzer's entry to hid_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/hid_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_hid_bytes({data, size});
  return 0;
}
