// See assignment.h.
#include "clients/sdk/assignment.h"

#include <vector>

namespace hapticd::client {

v1::Assignment assignment(const std::string& path, const Value& value) {
  v1::Assignment made;
  made.set_path(path);
  if (const auto* number = std::get_if<double>(&value.data)) {
    made.set_number(*number);
  } else if (const auto* flag = std::get_if<bool>(&value.data)) {
    made.set_flag(*flag);
  } else if (const auto* text = std::get_if<std::string>(&value.data)) {
    made.set_text(*text);
  } else {
    for (const double each : std::get<std::vector<double>>(value.data)) {
      made.mutable_numbers()->add_values(each);
    }
    made.mutable_numbers();
  }
  return made;
}

Value value_of(const v1::Assignment& assignment) {
  if (assignment.has_flag()) return assignment.flag();
  if (assignment.has_text()) return assignment.text();
  if (!assignment.has_numbers()) return assignment.number();
  const auto& numbers = assignment.numbers().values();
  return std::vector<double>(numbers.begin(), numbers.end());
}

}  // namespace hapticd::client
