// The table of requests as section 8 of proto/PROTOCOL.md prints it. Not RT.
#pragma once

#include <map>
#include <string>

namespace hapticd::test {

/// What each request needs: "", "control" or "lease". Throws std::runtime_error where the document
/// cannot be read.
[[nodiscard]] std::map<std::string, std::string> documented_requests();

}  // namespace hapticd::test
