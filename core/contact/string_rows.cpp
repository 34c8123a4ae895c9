// See string_rows.h. RT: yes.
#include "core/contact/string_rows.h"

#include <algorithm>

namespace hapticd {
namespace {

/// A string that a pair already holds off may come nearer at another one by this share of the skin:
/// both legs of a string that is hardly bent are nearly one obstacle, whose pairs would be
/// exchanged for each other string by string. Larger: forces less exact, by kt times as much;
/// smaller: more iterations where many strings are met at once.
constexpr double kTwinShare = 1e-3;

}  // namespace

void sort_by_string(std::size_t pressed, OptimiserWorkspace& w) noexcept {
  const auto string_of = [&w](std::int32_t c) {
    const ContactKey& key = w.contacts.contacts[static_cast<std::size_t>(c)].key;
    return key.kind == ObstacleKind::kCapsule ? key.obstacle : -1;
  };
  const auto first = w.contact_of_row.begin();
  std::sort(first, first + static_cast<std::ptrdiff_t>(pressed),
            [&string_of](std::int32_t a, std::int32_t b) {
              const std::int32_t string_a = string_of(a);
              const std::int32_t string_b = string_of(b);
              return string_a != string_b ? string_a < string_b : a < b;
            });
}

std::size_t keep_worst_of_strings(const ContactState& state, double skin, std::size_t violated,
                                  OptimiserWorkspace& w) noexcept {
  const auto hold_of = [&state, &w](std::int32_t c) {
    return find_touched(state.touched, w.contacts.contacts[static_cast<std::size_t>(c)].key);
  };
  std::array<bool, kMaxDeflectingStrings> held_off;
  held_off.fill(false);
  for (int k = 0; k < w.solution.active_count; ++k) {
    const auto row = static_cast<std::size_t>(w.solution.active[static_cast<std::size_t>(k)]);
    const int h = hold_of(w.contact_of_row[row]);
    if (h >= 0) held_off[static_cast<std::size_t>(h)] = true;
  }
  std::array<std::size_t, kMaxDeflectingStrings> worst;
  worst.fill(violated);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < violated; ++k) {
    const std::int32_t c = w.order[k];
    const int h = hold_of(c);
    if (h >= 0 && held_off[static_cast<std::size_t>(h)] &&
        w.excess[static_cast<std::size_t>(c)] < kTwinShare * skin) {
      continue;
    }
    std::size_t* const place = h >= 0 ? &worst[static_cast<std::size_t>(h)] : nullptr;
    if (place == nullptr || *place == violated) {
      if (place != nullptr) *place = kept;
      w.order[kept++] = c;
    } else if (w.excess[static_cast<std::size_t>(c)] >
               w.excess[static_cast<std::size_t>(w.order[*place])]) {
      w.order[*place] = c;
    }
  }
  return kept;
}

}  // namespace hapticd
