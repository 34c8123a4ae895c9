// See state_desk.h.
#include "server/daemon/state_desk.h"

namespace hapticd {

bool StateDesk::take(NetworkTicks& ticks) {
  if (!ticks.pop(*newest_)) return false;
  statistics_.add(*newest_);
  return true;
}

void StateDesk::add_to_hash() {
  const auto complete = [this](v1::State& state) { complete_(*newest_, state); };
  add_state(*newest_, scenes_.playing(newest_->scene_id).index, complete, hash_);
}

void StateDesk::fill(const Subscription& subscription, v1::State& state) {
  encode_state(*newest_, scenes_.playing(newest_->scene_id).index,
               {subscription.sections, subscription.max_contacts}, state);
  if (subscription.has(v1::SECTION_STAGES) || subscription.has(v1::SECTION_TIMING)) {
    statistics_.fill(*newest_, *state.mutable_timing());
  }
  complete_(*newest_, state);
  if (subscription.soundings_from) soundings_.add_to(*subscription.soundings_from, state);
}

}  // namespace hapticd
