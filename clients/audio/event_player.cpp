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
/// Pitch and partials of a StringSounding are reached within this time, s.
constexpr double kApproach_s = 0.01;
/// A pitch glides on for so long after it was told, s.
constexpr double kOnward_s = 0.1;
/// What is told may be so much louder than its Tone, or a tone of level 1: 12 dB.
constexpr double kMostGain = 4.0;
/// Shorter decays are not believed, s.
constexpr double kLeastDecay_s = 1e-6;
/// A string that nobody has released is heard from this share of the level 1 on.
constexpr double kLeastLevel = 0.01;

/// A note is over where its string dies away in less than this share of the decay of its tone.
constexpr double kShort = 0.5;

/// Of a fundamental with the energy of its partials, m.
double amplitude_of(const v1::StringSounding& sounding) {
  return energy_amplitude(
      {sounding.partials_m().data(), static_cast<std::size_t>(sounding.partials_m_size())});
}

/// Of the loudest partial, s.
double decay_of(const v1::StringSounding& sounding) {
  const auto& partials = sounding.partials_m();
  const auto loudest = std::max_element(partials.begin(), partials.end());
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

/// Of the partial that rings longest, s.
double longest_decay_of(const v1::StringSounding& sounding) {
  const auto& decays = sounding.decays_s();
  return static_cast<double>(*std::max_element(decays.begin(), decays.end()));
}

/// True where every number of it is one that a string can have.
bool is_sound(const v1::StringSounding& sounding) {
  const auto within = [](float value, double least, double most) {
    return static_cast<double>(value) >= least && static_cast<double>(value) <= most;
  };
  const auto all_within = [&](const auto& values, double least, double most) {
    return std::all_of(values.begin(), values.end(),
                       [&](float value) { return within(value, least, most); });
  };
  if (sounding.partials_m().empty()) return true;
  return sounding.partials_m_size() <= kToldPartials &&
         sounding.decays_s_size() == sounding.partials_m_size() &&
         all_within(sounding.partials_m(), 0.0, 1.0) && amplitude_of(sounding) > 0.0 &&
         all_within(sounding.decays_s(), kLeastDecay_s, 1000.0) &&
         within(sounding.frequency_hz(), 1.0, 2e4) && within(sounding.cents_per_s(), -1e5, 1e5) &&
         within(sounding.inharmonicity(), 0.0, 1e3);
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
    if (described.decay_s() > 0.0) string.open_decay_s = described.decay_s();
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
  const auto amplitude_m = static_cast<double>(tone.amplitude_m());
  sound.amplitude_m =
      amplitude_m > 0.0 && amplitude_m <= 1.0 ? amplitude_m : sound.level * reference_m_;
  sound.lambda = static_cast<double>(tone.lambda());
  sound.decay_s = static_cast<double>(tone.decay_s());
  sound.glide_cents = static_cast<double>(tone.glide_cents());
  sound.glide_decay_s = static_cast<double>(tone.glide_decay_s());
  sound.inharmonicity = string.inharmonicity;
  sound.partials = {tone.partials().data(), static_cast<std::size_t>(tone.partials_size())};
  strike(sound, string, due_ns);
  // What was told of the string since its release came before the Tone, as its onset does.
  if (string.sounds && string.told.t_ns() > tone.t_ns()) {
    tell(string, std::max(due_ns, string.told_due_ns));
  }
}

void EventPlayer::strike(const ToneSound& tone, String& string, std::int64_t due_ns) {
  std::optional<Strike> strike = design_string(tone, sound_);
  if (!strike) {
    ++counts_.unplayable;
    return;
  }
  string.gain = strike->gain;
  string.per_metre = strike->per_metre;
  string.released = true;
  if (string.recording != nullptr) play_recording(tone, string, *strike);
  string.decay_s = tone.decay_s;
  string.most_m = tone.amplitude_m;
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kStrike;
  order.strike = *strike;
  submit(order);
}

// A recording has its own decay: it lasts as long as it lasts.
void EventPlayer::play_recording(const ToneSound& tone, const String& string,
                                 Strike& strike) const {
  const ToneFile& file = *string.recording;
  const double recorded_hz = file.frequency_hz > 0.0 ? file.frequency_hz : string.frequency_hz;
  strike.gain = sound_.gain * tone.level * kLevelRms / file.rms;
  strike.recorded = {file.samples.data(), static_cast<std::int64_t>(file.samples.size()),
                     recorded_hz > 0.0 ? tone.frequency_hz / recorded_hz : 1.0};
  strike.frames =
      static_cast<std::int64_t>(static_cast<double>(file.samples.size()) / strike.recorded.step) +
      1;
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
  return !string.sounds || static_cast<std::int32_t>(sounding.number() - string.told.number()) > 0;
}

void EventPlayer::play_sounding(const v1::StringSounding& sounding, std::int64_t due_ns) {
  String& string = string_at(sounding.string_index());
  if (!is_news(sounding, string) || !is_sound(sounding)) return;
  string.sounds = true;
  string.silent = sounding.partials_m().empty();
  string.told = sounding;
  string.told_due_ns = due_ns;
  if (!string.silent && !(string.gain > 0.0) && !set_loudness(string)) {
    ++counts_.unplayable;
    return;
  }
  tell(string, due_ns);
}

bool EventPlayer::set_loudness(String& string) const {
  const v1::StringSounding& told = string.told;
  ToneSound sound;
  sound.frequency_hz = static_cast<double>(told.frequency_hz());
  sound.amplitude_m = amplitude_of(told);
  sound.level = std::min(1.0, sound.amplitude_m / reference_m_);
  // However it is damped: of a string that rings.
  sound.decay_s = std::max(longest_decay_of(told), string.open_decay_s);
  sound.partials = {told.partials_m().data(), static_cast<std::size_t>(told.partials_m_size())};
  const std::optional<Strike> strike = design_string(sound, sound_);
  if (!strike) return false;
  string.gain = strike->gain;
  string.per_metre = strike->per_metre;
  string.decay_s = sound.decay_s;
  string.most_m = sound.amplitude_m;
  return true;
}

void EventPlayer::tell(String& string, std::int64_t due_ns) {
  const double since_s = 1e-9 * static_cast<double>(due_ns - string.told_due_ns);
  Order order;
  order.due_ns = due_ns;
  order.kind = Order::Kind::kTelling;
  order.strike = strike_of_told(string, since_s);
  Telling& telling = order.telling;
  telling.bend = bend_to(string.told, since_s);
  telling.begins = string.released || amplitude_of(string.told) > kLeastLevel * reference_m_;
  telling.ends_note = string.silent || decay_of(string.told) < kShort * string.decay_s;
  submit(order);
}

Strike EventPlayer::strike_of_told(const String& string, double since_s) const {
  const v1::StringSounding& told = string.told;
  const double amplitude = amplitude_of(told);
  ToneSound sound;
  sound.string = static_cast<int>(told.string_index());
  sound.frequency_hz = string.silent ? 1.0 : static_cast<double>(told.frequency_hz());
  sound.level = std::min(1.0, amplitude / reference_m_);
  sound.decay_s = string.silent ? kStill_s : longest_decay_of(told);
  Strike strike = outline(sound, sound_);
  strike.gain = string.gain;
  strike.per_metre = string.per_metre;
  strike.sines = true;
  strike.log_hz = std::log(sound.frequency_hz);
  ToldPartials& partials = strike.partials;
  partials.count = told.partials_m_size();
  partials.omega = 2.0 * std::numbers::pi * sound.frequency_hz / sound_.rate_hz;
  partials.inharmonicity = static_cast<double>(told.inharmonicity());
  const double most = kMostGain * std::max(string.most_m, reference_m_);
  const double share = amplitude > most ? most / amplitude : 1.0;
  for (int k = 0; k < partials.count; ++k) {
    const auto n = static_cast<std::size_t>(k);
    const auto decay_s = static_cast<double>(told.decays_s(k));
    partials.amplitude[n] =
        share * static_cast<double>(told.partials_m(k)) * std::exp(-since_s / decay_s);
    partials.keep[n] = keep_per_frame(decay_s, sound_.rate_hz);
  }
  return strike;
}

// To where the pitch will be by then, and on from there.
Bend EventPlayer::bend_to(const v1::StringSounding& sounding, double since_s) const {
  const double per_step = kGlideStep / sound_.rate_hz;
  const double slope =
      static_cast<double>(sounding.cents_per_s()) * std::numbers::ln2 / 1200.0 * per_step;
  const double gone = std::min(since_s, kOnward_s) / per_step;
  Bend bend;
  // A voice begins it at its next step.
  bend.approach = std::max(1, static_cast<int>(kApproach_s / per_step) - 1);
  if (sounding.partials_m().empty()) return bend;
  bend.goal =
      std::log(static_cast<double>(sounding.frequency_hz())) + slope * (gone + bend.approach);
  const auto steps = static_cast<int>(std::lround(kOnward_s / per_step - gone));
  bend.onward = {slope, steps - bend.approach};
  return bend;
}

void EventPlayer::submit(const Order& order) {
  if (!submit_(order)) ++counts_.lost;
}

}  // namespace hapticd::audio
