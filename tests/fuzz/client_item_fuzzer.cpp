// libFuzzer's entry to client_item_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/client_item_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_client_items({data, size});
  return 0;
}
