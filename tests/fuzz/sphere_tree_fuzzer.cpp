// libFuzzer's entry to sphere_tree_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/sphere_tree_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hapticd::test::check_sphere_tree_bytes({data, size});
  return 0;
}
