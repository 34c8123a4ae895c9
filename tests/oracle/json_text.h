// JSON put together from pieces of text: numbers with all their bits, null for what is not a
// number. Not RT.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "core/math/vector.h"

namespace hapticd {

[[nodiscard]] std::string json(double value);
[[nodiscard]] std::string json(bool value);
[[nodiscard]] std::string json(std::size_t value);
[[nodiscard]] std::string json(const std::string& text);
[[nodiscard]] std::string json(const Vector3& v);
/// Of values that are JSON already.
[[nodiscard]] std::string json_array(const std::vector<std::string>& values);
/// Likewise, with their names.
[[nodiscard]] std::string json_object(
    std::initializer_list<std::pair<const char*, std::string>> members);

}  // namespace hapticd
