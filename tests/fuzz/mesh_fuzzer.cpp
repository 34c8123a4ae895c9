// libFuzzer's entry to mesh_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/mesh_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_mesh_bytes({data, size});
  return 0;
}
