// The corpus of meshes and mutations of it, as an ordinary test.
#include <doctest/doctest.h>

#include "tests/fuzz/mesh_target.h"
#include "tests/fuzz/replay.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no file crashes the reader of meshes, and a mesh that is taken has an inside") {
  const Replay result = replay("mesh", scaled(2'000), check_mesh_bytes);
  CHECK(result.taken >= 3);
  CHECK(result.taken < result.inputs);
}

}  // namespace hapticd::test
