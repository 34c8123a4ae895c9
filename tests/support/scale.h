// How much of a random or long test runs. Full counts (scale 1) take hours under a sanitizer, so
// every such test asks scaled() for its count. The environment variable HAPTICD_TEST_SCALE decides;
// unset, the preset's own value holds (0.1 for dev, 0.01 under sanitizers). Not RT.
#pragma once

#include <cstdint>

namespace hapticd::test {

/// Share of the full counts to run, in (0, 1]. Read once from HAPTICD_TEST_SCALE; a value that is
/// no number in that range ends the test executable with a message.
double test_scale();

/// full_count times test_scale(), rounded down, at least 1. full_count in [1, 2^53].
std::int64_t scaled(std::int64_t full_count);

}  // namespace hapticd::test
