// See json_text.h.
#include "tests/oracle/json_text.h"

#include <cmath>

#include "tests/oracle/table.h"

namespace hapticd {

std::string json(double value) { return std::isfinite(value) ? exact_text(value) : "null"; }

std::string json(bool value) { return value ? "true" : "false"; }

std::string json(std::size_t value) { return std::to_string(value); }

std::string json(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return quoted + "\"";
}

std::string json(const Vector3& v) { return json_array({json(v.x()), json(v.y()), json(v.z())}); }

std::string json_array(const std::vector<std::string>& values) {
  std::string text = "[";
  for (const std::string& value : values) text += (text.size() > 1 ? "," : "") + value;
  return text + "]";
}

std::string json_object(std::initializer_list<std::pair<const char*, std::string>> members) {
  std::string text = "{";
  for (const auto& [name, value] : members) {
    text += (text.size() > 1 ? "," : "") + json(std::string(name)) + ":" + value;
  }
  return text + "}";
}

}  // namespace hapticd
