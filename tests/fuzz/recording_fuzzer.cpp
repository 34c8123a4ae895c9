// libFuzzer's entry to recording_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/recording_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_recording_bytes({data, size});
  return 0;
}
