// libFuzzer's entry to pid_target.h.
#include "tests/fuzz/pid_target.h"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_pid_bytes({data, size});
  return 0;
}
