// See told_soundings.h.
#include "server/encoding/told_soundings.h"

namespace hapticd {

void ToldSoundings::take(std::uint32_t scene_id, const v1::Item& event) {
  if (!event.has_string_sounding()) return;
  if (scene_id != scene_id_) newest_.clear();
  scene_id_ = scene_id;
  const v1::StringSounding& sounding = event.string_sounding();
  if (sounding.partials_m().empty()) {
    newest_.erase(sounding.string_index());
    return;
  }
  v1::StringSounding& kept = newest_[sounding.string_index()];
  kept = sounding;
  // Those of the onset say nothing of a string that has rung since.
  kept.clear_phases_rad();
}

void ToldSoundings::add_to(std::uint32_t first, v1::State& state) const {
  if (state.scene_id() != scene_id_) return;
  for (v1::StringState& string : *state.mutable_strings()) {
    if (string.string_index() < first) continue;
    const auto found = newest_.find(string.string_index());
    if (found != newest_.end()) *string.mutable_sounding() = found->second;
  }
}

}  // namespace hapticd
