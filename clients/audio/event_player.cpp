// See event_player.h.
#include "clients/audio/event_player.h"

#include <algorithm>
#include <utility>

namespace hapticd::audio {
namespace {

/// Strings a scene may have; events about others are not believed.
constexpr std::uint32_t kMaxStrings = 1024;
/// How fast a string ends that the daemon has made still, s.
constexpr double kStill_s = 0.03;

}  // namespace

EventPlayer::EventPlayer(const Sound& sound, ToneFiles* tones, Submit submit)
    : sound_(sound), tones_(tones), submit_(std::move(submit)) {}

void EventPlayer::set_scene(const v1::Scene& scene) {
  // What sounds of the scene before rings on by itself.
  strings_.assign(static_cast<std::size_t>(scene.strings_size()), {});
  for (std::size_t i = 0; i < strings_.size(); ++i) {
    const v1::String& described = scene.strings(static_cast<int>(i));
    String& string = strings_[i];
    string.name = described.name();
    string.frequency_hz = described.frequency_hz();
    if (described.touch_decay_s() > 0.0) string.touch_decay_s = described.touch_decay_s();
    if (described.inharmonicity() > 0.0) string.inharmonicity = described.inharmonicity();
    if (tones_ != nullptr) string.recording = tones_->find(string.name);
  }
}

void EventPlayer::play(const v1::Item& event, std::int64_t due_ns) {
  if (event.has_tone() && event.tone().string_index() < kMaxStrings) {
    play_tone(event.tone(), due_ns);
  } else if (event.has_string_radius() && event.string_radius().string_index() < kMaxStrings) {
    play_radius(event.string_radius(), due_ns);
  }
}

EventPlayer::String& EventPlayer::string_at(std::uint32_t index) {
  if (index >= strings_.size()) strings_.resize(index + 1);
  return strings_[index];
}

void EventPlayer::play_tone(const v1::Tone& tone, std::int64_t due_ns) {
  ++counts_.tones;
  String& string = string_at(tone.string_index());
  ToneSound sound;
  sound.string = static_cast<int>(tone.string_index());
  sound.frequency_hz = static_cast<double>(tone.frequency_hz());
  sound.level = static_cast<double>(tone.level());
  sound.lambda = static_cast<double>(tone.lambda());
  sound.decay_s = static_cast<double>(tone.decay_s());
  sound.glide_cents = static_cast<double>(tone.glide_cents());
  sound.glide_decay_s = static_cast<double>(tone.glide_decay_s());
  sound.inharmonicity = string.inharmonicity;
  sound.partials = {tone.partials().data(), static_cast<std::size_t>(tone.partials_size())};
  const std::optional<Strike> strike = strike_of(sound, string);
  if (!strike) {
    ++counts_.unplayable;
    return;
  }
  string.decay_s = sound.decay_s;
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kStrike;
  order.strike = *strike;
  submit(order);
}

std::optional<Strike> EventPlayer::strike_of(const ToneSound& tone, const String& string) const {
  std::optional<Strike> strike = design_string(tone, sound_);
  if (!strike || string.recording == nullptr) return strike;
  const ToneFile& file = *string.recording;
  const double recorded_hz = file.frequency_hz > 0.0 ? file.frequency_hz : string.frequency_hz;
  strike->gain = sound_.gain * tone.level * kLevelRms / file.rms;
  strike->recorded = {file.samples.data(), static_cast<std::int64_t>(file.samples.size()),
                      recorded_hz > 0.0 ? tone.frequency_hz / recorded_hz : 1.0};
  // A recording has its own decay: it lasts as long as it lasts.
  strike->frames =
      static_cast<std::int64_t>(static_cast<double>(file.samples.size()) / strike->recorded.step) +
      1;
  return strike;
}

void EventPlayer::play_radius(const v1::StringRadius& radius, std::int64_t due_ns) {
  const String& string = string_at(radius.string_index());
  if (!(string.decay_s > 0.0)) return;  // it has not sounded
  double decay_s = static_cast<double>(radius.decay_s());
  if (radius.phase() == v1::STRING_RADIUS_PHASE_PRESS) decay_s = string.touch_decay_s;
  if (radius.phase() == v1::STRING_RADIUS_PHASE_RELEASE && !(radius.r_max_m() > 0.0F)) {
    decay_s = kStill_s;
  }
  if (!(decay_s > 0.0)) return;
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kDamp;
  order.damping.string = static_cast<std::int32_t>(radius.string_index());
  // The tone decays by itself; the finger does the rest.
  const double rest = 1.0 / decay_s - 1.0 / string.decay_s;
  order.damping.keep = rest > 1e-6 ? keep_per_frame(1.0 / rest, sound_.rate_hz) : 1.0;
  submit(order);
}

void EventPlayer::submit(const Order& order) {
  if (!submit_(order)) ++counts_.lost;
}

}  // namespace hapticd::audio
