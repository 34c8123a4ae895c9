// See state_desk.h.
#include "server/daemon/state_desk.h"

namespace hapticd {

void StateDesk::take(const Snapshot& snapshot) {
  snapshot_ = &snapshot;
  statistics_.add(snapshot);
}

void StateDesk::add_to_hash() {
  const auto complete = [this](v1::State& state) { complete_(*snapshot_, state); };
  add_state(*snapshot_, scenes_.playing(snapshot_->scene_id).index, complete, hash_);
}

void StateDesk::fill(const Subscription& subscription, v1::State& state) {
  encode_state(*snapshot_, scenes_.playing(snapshot_->scene_id).index,
               {subscription.sections, subscription.max_contacts}, state);
  const bool stages = subscription.has(v1::SECTION_STAGES);
  if (stages || subscription.has(v1::SECTION_TIMING)) {
    statistics_.fill(*snapshot_, stages, *state.mutable_timing());
  }
  complete_(*snapshot_, state);
}

}  // namespace hapticd
