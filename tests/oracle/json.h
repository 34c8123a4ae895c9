// What the oracle answers with, as JSON: members in the order in which they are written, doubles
// that read back as the same number, null for what is no number. Not RT.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/math/vector.h"

namespace hapticd {

using Json = nlohmann::ordered_json;

[[nodiscard]] inline Json json_of(const Vector3& v) { return Json::array({v.x(), v.y(), v.z()}); }

/// In one line, without its end. What is not UTF-8 is replaced.
[[nodiscard]] inline std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace hapticd
