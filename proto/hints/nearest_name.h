// What somebody meant who typed a name that is not there. Not RT.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace hapticd::hints {

/// The one of `names` that is most like `name`: it begins with it, or differs in a third of its
/// letters at most, of a short name in one, where a letter may be wrong, missing, too many or
/// exchanged with the next, and case does not count. Empty: none does, or `name` has more than 64
/// bytes. Cost: as the product of the lengths, for each of `names`.
[[nodiscard]] std::string nearest_name(std::string_view name, std::span<const std::string> names);

/// " Did you mean NAME?" with the nearest of `names`; empty where there is none.
[[nodiscard]] std::string did_you_mean(std::string_view name, std::span<const std::string> names);

}  // namespace hapticd::hints
