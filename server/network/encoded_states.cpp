// See encoded_states.h.
#include "server/network/encoded_states.h"

#include <utility>

#include "server/network/state_fitting.h"

namespace hapticd {

EncodedStates::Filled& EncodedStates::filled(const Subscription& subscription, const Fill& fill) {
  for (std::size_t i = 0; i < used_; ++i) {
    if (all_[i].subscription == subscription) return all_[i];
  }
  if (used_ == all_.size()) all_.emplace_back();
  Filled& fresh = all_[used_];
  fresh.subscription = subscription;
  fresh.state.Clear();
  fresh.state.set_tick(tick_);
  fresh.state.set_scene_id(scene_id_);
  fresh.is_whole = false;
  fresh.fitted.clear();
  fill(subscription, fresh.state);
  fresh.bytes = fresh.state.ByteSizeLong();
  ++used_;
  return fresh;
}

// Into the memory of an earlier tick, unless a session still has that to repeat it.
void EncodedStates::write_whole(Filled& filled) {
  if (filled.whole == nullptr || filled.whole.use_count() > 1) {
    auto whole = std::make_shared<EncodedState>();
    whole->parts.resize(1);
    filled.whole = std::move(whole);
  }
  std::string& bytes = filled.whole->parts[0];
  bytes.resize(filled.bytes);
  // The sizes are those that ByteSizeLong() left in the State.
  filled.state.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bytes.data()));
  filled.is_whole = true;
}

std::shared_ptr<const EncodedState> EncodedStates::get(const Subscription& subscription,
                                                       std::size_t room, const Fill& fill,
                                                       std::span<const double> rest_radii_m) {
  Filled& filled_in = filled(subscription, fill);
  if (filled_in.bytes <= room) {
    if (!filled_in.is_whole) write_whole(filled_in);
    return filled_in.whole;
  }
  for (const Fitted& fitted : filled_in.fitted) {
    if (fitted.room == room) return fitted.encoded;
  }
  EncodedState encoded;
  const std::vector<v1::State> parts = fit_state(filled_in.state, room, rest_radii_m);
  encoded.soundings_from = soundings_left(filled_in.state, parts.front());
  for (const v1::State& part : parts) {
    if (part.ByteSizeLong() > room) {
      ++encoded.unfit;
    } else {
      encoded.parts.push_back(part.SerializeAsString());
    }
  }
  filled_in.fitted.push_back({room, std::make_shared<const EncodedState>(std::move(encoded))});
  return filled_in.fitted.back().encoded;
}

}  // namespace hapticd
