// Makes a State fit into datagrams: PROTOCOL.md, section 6. What is repeated of strings that sound
// goes first, but for one of them, since it can follow in the next State; then contacts, largest
// gap first; then strings, those that look most at rest first; where the tools alone do not fit,
// the tick is spread over several States. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hapticd/v1/state.pb.h"

namespace hapticd {

/// `state` as States of at most `bytes` encoded bytes each: one, or as many parts as its tools
/// need. rest_radii_m: radius of each string at rest, by index; a string without one counts as thin
/// as 0. Totals already set are kept. A part that even then is too long (one tool with everything
/// there is fits into 1000 bytes) is returned as it is. O(n log n) in contacts and strings.
[[nodiscard]] std::vector<v1::State> fit_state(const v1::State& state, std::size_t bytes,
                                               std::span<const double> rest_radii_m);

/// Index of the first string whose sounding `whole` has and `first`, the first of its parts, has
/// not; nothing where none is missing. A string that was left out itself has had its turn: it is
/// not waited for.
[[nodiscard]] std::optional<std::uint32_t> soundings_left(const v1::State& whole,
                                                          const v1::State& first);

}  // namespace hapticd
