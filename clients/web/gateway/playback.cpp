// See playback.h.
#include "clients/web/gateway/playback.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "proto/recording/recorded_state.h"

namespace hapticd::web {
namespace {

/// States shown in one step of advance() at most.
constexpr std::size_t kMaxStates = 3;

template <typename Message>
Message parsed(const RecordedMessage& from) {
  Message message;
  // Half a message is shown as far as it goes: nothing is computed from it.
  (void)message.ParsePartialFromArray(from.data.data(), static_cast<int>(from.data.size()));
  return message;
}

/// First format whose ticks hold what clients were shown.
constexpr std::uint32_t kShownFormat = 3;

v1::SceneInfo scene_info_of(const v1::SceneRecord& record, const v1::RecordHeader& header) {
  v1::SceneInfo info;
  info.set_scene_id(record.scene_id());
  *info.mutable_scene() = record.scene();
  *info.mutable_quality_in_force() = record.scene().quality();
  *info.mutable_solver_in_force() = record.scene().solver();
  info.set_hash(record.hash());
  *info.mutable_assets() = record.assets();
  if (header.period_ns() > 0) info.set_rate_hz(1e9 / static_cast<double>(header.period_ns()));
  info.set_clock(header.config().clock());
  info.set_server_version(header.server_version());
  return info;
}

}  // namespace

Playback::Playback(const std::filesystem::path& file, PlaybackHandlers handlers)
    : recording_(file), handlers_(std::move(handlers)) {
  for (std::size_t i = 0; i < recording_.size(); ++i) {
    const RecordedMessage& message = recording_[i];
    if (message.kind == RecordKind::kScene) scenes_.push_back(i);
    if (message.kind != RecordKind::kTick) continue;
    // Time that goes back, as no recorder writes it, would break the search.
    const std::uint64_t earlier_ns = ticks_.empty() ? 0 : ticks_.back().time_ns;
    ticks_.push_back({std::max(earlier_ns, message.time_ns), i});
  }
  if (ticks_.empty()) {
    throw std::runtime_error(file.string() + ": it has no tick. Record longer");
  }
}

bool Playback::tools_only() const noexcept {
  return recording_.header().format_version() < kShownFormat;
}

double Playback::length_s() const {
  return static_cast<double>(ticks_.back().time_ns - ticks_.front().time_ns) * 1e-9;
}

std::uint64_t Playback::time_at(double position_s) const {
  return ticks_.front().time_ns + static_cast<std::uint64_t>(std::llround(position_s * 1e9));
}

std::size_t Playback::ticks_until(std::uint64_t time_ns) const {
  const auto after =
      std::upper_bound(ticks_.begin(), ticks_.end(), time_ns,
                       [](std::uint64_t time, const Tick& tick) { return time < tick.time_ns; });
  return static_cast<std::size_t>(after - ticks_.begin());
}

void Playback::begin() {
  seek(0.0);
  playing_ = true;
}

void Playback::tell_scene(std::size_t message) {
  if (shown_scene_ == message) return;
  shown_scene_ = message;
  v1::Item item;
  *item.mutable_scene_info() =
      scene_info_of(parsed<v1::SceneRecord>(recording_[message]), recording_.header());
  if (handlers_.item) handlers_.item(item);
}

void Playback::tell(std::size_t message) {
  const RecordedMessage& told = recording_[message];
  if (told.kind == RecordKind::kScene) tell_scene(message);
  if (told.kind != RecordKind::kEvent || !handlers_.item) return;
  handlers_.item(parsed<v1::EventRecord>(told).item());
}

void Playback::show(std::size_t tick) {
  const auto record = parsed<v1::TickRecord>(recording_[ticks_[tick].message]);
  shown_tick_time_ns_ = ticks_[tick].time_ns;
  shown_tick_t_ns_ = record.t_ns();
  if (handlers_.state) handlers_.state(state_of(record));
}

void Playback::seek(double position_s) {
  position_s_ = std::clamp(position_s, 0.0, length_s());
  const std::size_t target = std::max<std::size_t>(ticks_until(time_at(position_s_)), 1) - 1;
  const std::size_t end = ticks_[target].message + 1;
  const auto after = std::lower_bound(scenes_.begin(), scenes_.end(), end);
  if (after != scenes_.begin()) tell_scene(*std::prev(after));
  next_ = end;
  show(target);
}

void Playback::advance(double elapsed_s) {
  if (!playing_) return;
  position_s_ += elapsed_s * rate_;
  if (position_s_ >= length_s()) {
    position_s_ = length_s();
    playing_ = false;
  }
  const std::size_t last = ticks_until(time_at(position_s_));
  if (last == 0) return;
  // Ticks of this step, and which of them are shown: the last one always.
  std::size_t tick =
      static_cast<std::size_t>(std::lower_bound(ticks_.begin(), ticks_.end(), next_,
                                                [](const Tick& each, std::size_t message) {
                                                  return each.message < message;
                                                }) -
                               ticks_.begin());
  const std::size_t count = last > tick ? last - tick : 0;
  const std::size_t stride = (count + kMaxStates - 1) / kMaxStates;
  for (; tick < last; ++tick) {
    for (; next_ <= ticks_[tick].message; ++next_) tell(next_);
    if ((last - 1 - tick) % stride == 0) show(tick);
  }
}

void Playback::steer(const v1::PagePlayback& wanted) {
  const bool played = playing_;
  playing_ = wanted.playing();
  if (std::isfinite(wanted.rate()) && wanted.rate() > 0.0) {
    rate_ = std::min(wanted.rate(), kMaxRate);
  }
  if (!std::isfinite(wanted.position_s())) return;
  const double distance_s = std::fabs(wanted.position_s() - position_s_);
  if (played && playing_ && distance_s <= kSamePlace_s) return;
  seek(wanted.position_s());
}

v1::PagePlayback Playback::position() const {
  v1::PagePlayback position;
  position.set_position_s(position_s_);
  position.set_duration_s(length_s());
  position.set_playing(playing_);
  position.set_rate(rate_);
  return position;
}

std::int64_t Playback::shown_t_ns() const {
  const auto ahead_ns = static_cast<std::int64_t>(time_at(position_s_)) -
                        static_cast<std::int64_t>(shown_tick_time_ns_);
  return static_cast<std::int64_t>(shown_tick_t_ns_) + ahead_ns;
}

}  // namespace hapticd::web
