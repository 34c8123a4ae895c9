// libFuzzer's entry to datagram_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/datagram_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_datagram_bytes({data, size});
  return 0;
}
