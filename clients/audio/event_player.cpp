// See event_player.h.
#include "clients/audio/event_player.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace hapticd::audio {
namespace {

/// Strings a scene may have; events about others are not believed.
constexpr std::uint32_t kMaxStrings = 1024;
/// How fast a string ends that the daemon has made still, s.
constexpr double kStill_s = 0.03;
/// Pitch and loudness of a StringSounding are reached within this time, s.
constexpr double kApproach_s = 0.01;
/// A pitch glides on for so long after it was told, s.
constexpr double kOnward_s = 0.1;
/// What is told may be so much louder than what was to be expected: 12 dB.
constexpr double kMostGain = 4.0;
/// A string that nobody has released is heard from this share of the level 1 on.
constexpr double kLeastLevel = 0.01;

/// Of all partials together, m.
double amplitude_of(const v1::StringSounding& sounding) {
  double sum = 0.0;
  for (const float partial : sounding.partials_m()) {
    sum += static_cast<double>(partial) * static_cast<double>(partial);
  }
  return std::sqrt(sum);
}

/// Of the loudest partial, s; 0 where it says none.
double decay_of(const v1::StringSounding& sounding) {
  if (sounding.decays_s_size() < sounding.partials_m_size()) return 0.0;
  const auto& partials = sounding.partials_m();
  const auto loudest = std::max_element(partials.begin(), partials.end());
  if (loudest == partials.end()) return 0.0;
  return static_cast<double>(sounding.decays_s(static_cast<int>(loudest - partials.begin())));
}

/// The same as it is at t_ns, if nobody has told anything since.
v1::StringSounding carried_on(const v1::StringSounding& sounding, std::uint64_t t_ns) {
  v1::StringSounding now = sounding;
  if (t_ns <= sounding.t_ns()) return now;
  const double since = 1e-9 * static_cast<double>(t_ns - sounding.t_ns());
  const double cents = static_cast<double>(sounding.cents_per_s()) * std::min(since, kOnward_s);
  now.set_t_ns(t_ns);
  now.set_frequency_hz(
      static_cast<float>(static_cast<double>(sounding.frequency_hz()) * std::exp2(cents / 1200.0)));
  if (since >= kOnward_s) now.set_cents_per_s(0.0F);
  for (int k = 0; k < std::min(now.partials_m_size(), now.decays_s_size()); ++k) {
    const auto decay = static_cast<double>(now.decays_s(k));
    now.set_partials_m(
        k, static_cast<float>(static_cast<double>(now.partials_m(k)) * std::exp(-since / decay)));
  }
  return now;
}

/// True where every number of it is one that a string can have.
bool is_sound(const v1::StringSounding& sounding) {
  const auto within = [](float value, double least, double most) {
    return static_cast<double>(value) >= least && static_cast<double>(value) <= most;
  };
  if (sounding.partials_m().empty()) return true;
  const bool all = std::all_of(sounding.partials_m().begin(), sounding.partials_m().end(),
                               [&](float partial) { return within(partial, 0.0, 1.0); });
  return all && amplitude_of(sounding) > 0.0 && decay_of(sounding) > 0.0 &&
         within(sounding.frequency_hz(), 1.0, 2e4) && within(sounding.cents_per_s(), -1e5, 1e5);
}

}  // namespace

EventPlayer::EventPlayer(const Sound& sound, ToneFiles* tones, Submit submit)
    : sound_(sound), tones_(tones), submit_(std::move(submit)) {}

void EventPlayer::set_scene(const v1::Scene& scene) {
  // What sounds of the scene before rings on by itself.
  strings_.assign(static_cast<std::size_t>(scene.strings_size()), {});
  if (scene.tones().reference_amplitude_m() > 0.0) {
    reference_m_ = scene.tones().reference_amplitude_m();
  }
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
  } else if (event.has_string_sounding() && event.string_sounding().string_index() < kMaxStrings) {
    play_sounding(event.string_sounding(), due_ns);
  }
}

void EventPlayer::join(const v1::State& state, std::int64_t due_ns) {
  for (const v1::StringState& each : state.strings()) {
    if (!each.has_sounding() || each.string_index() >= kMaxStrings) continue;
    const v1::StringSounding& sounding = each.sounding();
    if (sounding.string_index() != each.string_index()) continue;
    if (!is_news(sounding, string_at(each.string_index())) || !is_sound(sounding)) continue;
    play_sounding(carried_on(sounding, state.t_ns()), due_ns);
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
  strike(sound, string, due_ns);
}

void EventPlayer::strike(const ToneSound& tone, String& string, std::int64_t due_ns) {
  const std::optional<Strike> strike = strike_of(tone, string);
  if (!strike) {
    ++counts_.unplayable;
    return;
  }
  string.decay_s = tone.decay_s;
  string.tone_hz = tone.frequency_hz;
  string.told_amplitude = 0.0;
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
  if (string.sounds || !(string.decay_s > 0.0)) return;  // it says it better, or has not sounded
  double decay_s = static_cast<double>(radius.decay_s());
  if (radius.phase() == v1::STRING_RADIUS_PHASE_PRESS) decay_s = string.touch_decay_s;
  if (radius.phase() == v1::STRING_RADIUS_PHASE_RELEASE && !(radius.r_max_m() > 0.0F)) {
    decay_s = kStill_s;
  }
  if (!(decay_s > 0.0)) return;
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kChange;
  order.change.string = static_cast<std::int32_t>(radius.string_index());
  order.change.keep = keep_of(string, decay_s);
  submit(order);
}

// The tone decays by itself; the finger does the rest.
double EventPlayer::keep_of(const String& string, double decay_s) const {
  const double rest = 1.0 / decay_s - 1.0 / string.decay_s;
  return rest > 1e-6 ? keep_per_frame(1.0 / rest, sound_.rate_hz) : 1.0;
}

bool EventPlayer::is_news(const v1::StringSounding& sounding, const String& string) {
  return !string.sounds || static_cast<std::int32_t>(sounding.number() - string.number) > 0;
}

void EventPlayer::play_sounding(const v1::StringSounding& sounding, std::int64_t due_ns) {
  String& string = string_at(sounding.string_index());
  if (!is_news(sounding, string) || !is_sound(sounding)) return;
  string.sounds = true;
  string.number = sounding.number();
  const double amplitude = amplitude_of(sounding);
  if (!(string.decay_s > 0.0)) {
    if (amplitude > 0.0) begin_sounding(sounding, due_ns);
    return;
  }
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kChange;
  Change& change = order.change;
  change.string = static_cast<std::int32_t>(sounding.string_index());
  if (!(amplitude > 0.0)) {
    change.keep = keep_of(string, kStill_s);
    string.decay_s = 0.0;
    submit(order);
    return;
  }
  const auto t_ns = static_cast<std::int64_t>(sounding.t_ns());
  const double decay_s = decay_of(sounding);
  change.bends = true;
  change.keep = keep_of(string, decay_s);
  change.bend = bend_to(sounding, string);
  if (string.told_amplitude > 0.0) {
    const double since = 1e-9 * static_cast<double>(t_ns - string.told_ns);
    const double expected = string.told_amplitude * std::exp(-since / string.told_decay_s);
    change.gain = std::clamp(amplitude / expected, 0.0, kMostGain);
  }
  string.told_ns = t_ns;
  string.told_amplitude = amplitude;
  string.told_decay_s = decay_s;
  submit(order);
}

// To where the pitch will be by then, and on from there.
Bend EventPlayer::bend_to(const v1::StringSounding& sounding, const String& string) const {
  const double per_step = kGlideStep / sound_.rate_hz;
  const double slope =
      static_cast<double>(sounding.cents_per_s()) * std::numbers::ln2 / 1200.0 * per_step;
  Bend bend;
  bend.approach = std::max(1, static_cast<int>(std::lround(kApproach_s / per_step)));
  const double now = std::log(static_cast<double>(sounding.frequency_hz()) / string.tone_hz);
  bend.goal = std::clamp(now + slope * bend.approach, -kMaxBend, kMaxBend);
  bend.onward = {slope, static_cast<int>(std::lround(kOnward_s / per_step)) - bend.approach};
  return bend;
}

void EventPlayer::begin_sounding(const v1::StringSounding& sounding, std::int64_t due_ns) {
  String& string = string_at(sounding.string_index());
  ToneSound sound;
  sound.string = static_cast<int>(sounding.string_index());
  sound.frequency_hz = static_cast<double>(sounding.frequency_hz());
  sound.level = std::min(1.0, amplitude_of(sounding) / reference_m_);
  sound.decay_s = decay_of(sounding);
  sound.inharmonicity = string.inharmonicity;
  sound.partials = {sounding.partials_m().data(),
                    static_cast<std::size_t>(sounding.partials_m_size())};
  if (sound.level < kLeastLevel) return;
  strike(sound, string, due_ns);
}

void EventPlayer::submit(const Order& order) {
  if (!submit_(order)) ++counts_.lost;
}

}  // namespace hapticd::audio
