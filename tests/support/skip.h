// Skips a test case that cannot run on this machine: for what its kernel or processor cannot do.
// What a package can bring is said by REQUIRES in CMake.
#pragma once

#include <string>

namespace hapticd::test {

/// Names the reason; the test executable then ends as skipped, unless a check fails. Return from
/// the test case after it.
void skip(const std::string& reason);

}  // namespace hapticd::test
