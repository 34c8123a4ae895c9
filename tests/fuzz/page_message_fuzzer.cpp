// libFuzzer's entry to page_message_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/page_message_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_page_messages({data, size});
  return 0;
}
