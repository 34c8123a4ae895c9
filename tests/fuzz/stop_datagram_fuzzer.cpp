// libFuzzer's entry to stop_datagram_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/stop_datagram_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_stop_datagrams({data, size});
  return 0;
}
