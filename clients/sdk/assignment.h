// Values of parameters as the protocol has them. Pure. Not RT.
#pragma once

#include <hapticd/client/value.h>
#include <hapticd/v1/control.pb.h>

#include <string>

namespace hapticd::client {

/// Sets `path` to `value`.
[[nodiscard]] v1::Assignment assignment(const std::string& path, const Value& value);
/// The value of an Assignment; 0 where it has none that this version knows.
[[nodiscard]] Value value_of(const v1::Assignment& assignment);

}  // namespace hapticd::client
