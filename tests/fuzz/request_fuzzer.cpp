// libFuzzer's entry to request_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/request_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_requests({data, size});
  return 0;
}
