// libFuzzer's entry to configuration_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/configuration_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_configuration_bytes({data, size});
  return 0;
}
