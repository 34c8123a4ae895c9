// libFuzzer's entry to scene_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/scene_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_scene_bytes({data, size});
  return 0;
}
