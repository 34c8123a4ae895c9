// Parameters of a model by name: one table per struct of parameters states name, unit, range and
// meaning of every field, for checks, for tools that set them by name, and for their help. Offline.
#pragma once

#include <array>
#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace hapticd {

/// What a parameter may be. Its default is that of a default-constructed struct.
struct ModelRange {
  std::string_view name;
  std::string_view unit;  ///< "m", "1"
  double low;
  double high;
  std::string_view meaning;
};

/// A parameter of the struct T.
template <typename T>
struct ParameterField {
  ModelRange range;
  double T::*member;
};

/// Throws std::invalid_argument naming `model`, the parameter, its value and the range unless low
/// <= value <= high.
inline void check_in_range(std::string_view model, const ModelRange& range, double value) {
  if (value >= range.low && value <= range.high) return;
  std::ostringstream text;
  text << model << ": " << range.name << " is " << value << ", must be from " << range.low << " to "
       << range.high << " " << range.unit;
  throw std::invalid_argument(text.str());
}

/// check_in_range of every field of the table.
template <typename T, std::size_t Count>
void check_parameters(std::string_view model, const std::array<ParameterField<T>, Count>& fields,
                      const T& parameters) {
  for (const ParameterField<T>& field : fields) {
    check_in_range(model, field.range, parameters.*field.member);
  }
}

}  // namespace hapticd
