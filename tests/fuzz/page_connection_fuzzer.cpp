// libFuzzer's entry to page_connection_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/page_connection_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_page_connection({data, size});
  return 0;
}
