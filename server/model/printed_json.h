// The line of JSON that a command prints with --json. Not RT.
#pragma once

#include <nlohmann/json.hpp>

namespace hapticd {

/// Members in the order in which they were added.
using Json = nlohmann::ordered_json;

/// To stdout, in one line; valid UTF-8 whatever is in it.
void print_json(const Json& json);

}  // namespace hapticd
