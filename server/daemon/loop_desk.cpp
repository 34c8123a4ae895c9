// See loop_desk.h.
#include "server/daemon/loop_desk.h"

#include <algorithm>
#include <string>

#include "proto/wire/request_result.h"
#include "server/daemon/log_text.h"
#include "server/encoding/encode_event.h"

namespace hapticd {
namespace {

using wire::result_of;

/// Lends `thing`, which is not obeyed before its command comes. False when there is no room.
template <typename Thing, std::size_t Capacity>
bool lend_through(Lending<Thing, Capacity>& channel, std::size_t& lent,
                  std::unique_ptr<Thing>& thing) noexcept {
  if (lent == Capacity || !channel.lent.push(thing)) return false;
  ++lent;
  return true;
}

/// Frees what has been given back. What a replay gave to the loop was not lent here.
template <typename Thing, std::size_t Capacity>
void take_back_through(Lending<Thing, Capacity>& channel, std::size_t& lent) noexcept {
  while (channel.back.pop() != nullptr) {
    if (lent > 0) --lent;
  }
}

}  // namespace

LoopDesk::LoopDesk(ServedClients& clients, bool stepped_here)
    : clients_(clients), stepped_here_(stepped_here), channels_(std::make_unique<LoopChannels>()) {}

void LoopDesk::begin(const LoopOptions& options, std::unique_ptr<PlayedScene> first,
                     std::function<void(const LoopEvent&)> on_event) {
  on_event_ = std::move(on_event);
  loop_ = std::make_unique<HapticLoop>(options, std::move(first), *channels_);
}

bool LoopDesk::post(const LoopCommandBody& what) {
  return channels_->commands.push({++last_number_, what});
}

bool LoopDesk::has_room() const noexcept {
  return channels_->commands.size() < channels_->commands.capacity();
}

// Its number is not used again.
Answer LoopDesk::refuse() {
  ++last_number_;
  return result_of(v1::RESULT_CODE_BUSY, "", "Too many commands at once.");
}

Answer LoopDesk::command(const RequestId& id, const LoopCommandBody& what) {
  if (!has_room()) return refuse();
  waiting_.push_back({next_number(), id, ""});
  post(what);
  follow();
  return std::nullopt;
}

// Whoever waits is noted first: after that nothing asks for memory, and what was lent has its
// command.
template <typename Lend>
Answer LoopDesk::lend(const std::optional<RequestId>& id, const LoopCommandBody& what,
                      const Lend& lend_thing) {
  if (!has_room()) return refuse();
  if (id) waiting_.push_back({next_number(), *id, ""});
  if (!lend_thing()) {
    if (id) waiting_.pop_back();
    return refuse();
  }
  post(what);
  return std::nullopt;
}

Answer LoopDesk::lend(const RequestId& id, std::unique_ptr<GesturePlan> plan) {
  Answer refused = lend(id, PlayGestureCommand{},
                        [&] { return lend_through(channels_->gestures, gestures_lent_, plan); });
  if (!refused) follow();
  return refused;
}

Answer LoopDesk::lend(const std::optional<RequestId>& id, std::unique_ptr<SettingsChange> change) {
  Answer refused = lend(id, ChangeSettingsCommand{},
                        [&] { return lend_through(channels_->changes, changes_lent_, change); });
  if (!refused && id) follow();
  return refused;
}

Answer LoopDesk::lend(const std::optional<RequestId>& id, std::unique_ptr<PlayedScene> scene,
                      std::string told) {
  Answer refused = lend(id, SwapSceneCommand{},
                        [&] { return lend_through(channels_->scenes, scenes_lent_, scene); });
  if (!refused && id) waiting_.back().told = std::move(told);
  if (!refused) follow();
  return refused;
}

void LoopDesk::obey() {
  if (stepped_here_) loop_->take_commands();
}

void LoopDesk::follow() {
  obey();
  if (stepped_here_) take_events();
}

void LoopDesk::take_events() {
  LoopEvent event;
  while (channels_->events.pop(event)) {
    within_memory([&] { on_event_(event); });
    settle(event);
  }
  take_back();
  LogRecord record;
  while (channels_->log.pop(record)) within_memory([&] { write_log(record); });
}

void LoopDesk::settle(const LoopEvent& event) {
  if (const auto* done = std::get_if<CommandDone>(&event.what)) {
    finish(done->number,
           [](const std::string& told) { return result_of(v1::RESULT_CODE_OK, "", told); });
  } else if (const auto* refused = std::get_if<CommandRefused>(&event.what)) {
    finish(refused->number, [&](const std::string& /*told*/) {
      return result_of(v1::RESULT_CODE_WRONG_STATE, "", std::string(explain(refused->cause)));
    });
  }
}

void LoopDesk::take_back() noexcept {
  take_back_through(channels_->scenes, scenes_lent_);
  take_back_through(channels_->gestures, gestures_lent_);
  take_back_through(channels_->changes, changes_lent_);
}

template <typename MakeResult>
void LoopDesk::finish(std::uint64_t number, MakeResult&& make_result) {
  // They are obeyed in order.
  if (number >= lease_end_number_) lease_end_number_ = 0;
  const auto same = [&](const auto& command) { return command.number == number; };
  const auto found = std::find_if(waiting_.begin(), waiting_.end(), same);
  if (found == waiting_.end()) return;
  const Waiting done = std::move(*found);
  waiting_.erase(found);
  clients_.answer_with(done.id, [&] { return make_result(done.told); });
}

void LoopDesk::lose_lease() {
  ++lease_ends_;
  tell_lease_ends();
}

void LoopDesk::tell_lease_ends() {
  if (told_lease_ends_ == lease_ends_) return;
  if (post(LeaseLostCommand{lease_ends_})) {
    told_lease_ends_ = lease_ends_;
    lease_end_number_ = last_number_;
  }
  obey();
}

bool LoopDesk::knows_lease_ends() const noexcept {
  return ending_ || (told_lease_ends_ == lease_ends_ && lease_end_number_ == 0);
}

void LoopDesk::end() {
  ending_ = true;
  channels_->commands.push({0, EndCommand{}});
}

void LoopDesk::note(const Tick& tick) noexcept {
  state_ = tick.state;
  newest_tick_ = tick.tick;
}

std::uint64_t LoopDesk::next_tick() const noexcept {
  return stepped_here_ ? loop_->next_tick() : newest_tick_ + 1;
}

}  // namespace hapticd
