// The reader of sphere-tree files over its corpus and mutations of it, without a fuzzer.
#include <doctest/doctest.h>

#include "tests/fuzz/replay.h"
#include "tests/fuzz/sphere_tree_target.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("no mutation of a sphere-tree file crashes its reader or is read as an unsound tree") {
  const std::int64_t mutations = scaled(100'000);
  const Replay result = replay("sphere_tree", mutations, check_sphere_tree_bytes);
  CHECK(result.inputs > mutations);
  // The corpus itself is taken, and so are changes of lengths that harm nothing.
  CHECK(result.taken >= 4);
}

}  // namespace hapticd::test
