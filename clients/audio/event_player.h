// Turns the daemon's events into orders for the audio engine: a Tone into a strike, a
// StringSounding into a bend of its pitch and loudness, and for strings that send none a
// StringRadius into the damping of one that a finger touches, or its end. What was told before the
// player came is repeated in States: a string that rings is begun from there. Knows the scene, for
// the strings' names and stiffness, and the recordings. Instants are given by the caller. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/audio/dsp/timeline.h"
#include "clients/audio/string_design.h"
#include "clients/audio/tone_files.h"
#include "hapticd/v1/state.pb.h"
#include "hapticd/v1/stream.pb.h"

namespace hapticd::audio {

/// What has come in so far.
struct EventCounts {
  std::uint64_t tones = 0;
  std::uint64_t unplayable = 0;  ///< a pitch that does not fit, or numbers out of range
  std::uint64_t lost = 0;        ///< the ring was full
};

class EventPlayer {
 public:
  /// Takes an order to the engine; false when there was no room.
  using Submit = std::function<bool(const Order&)>;

  /// `tones`: recordings, which the player asks for by the names of strings; null: all strings are
  /// computed. It outlives the player.
  EventPlayer(const Sound& sound, ToneFiles* tones, Submit submit);

  /// Another scene plays.
  void set_scene(const v1::Scene& scene);
  /// An event, to be heard at due_ns. Anything but Tone, StringSounding and StringRadius is left
  /// alone.
  void play(const v1::Item& event, std::int64_t due_ns);
  /// What `state` repeats of strings that sound, as they sound at its instant, to be heard at
  /// due_ns. What events have told already changes nothing.
  void join(const v1::State& state, std::int64_t due_ns);

  [[nodiscard]] const EventCounts& counts() const noexcept { return counts_; }

 private:
  struct String {
    std::string name;
    double frequency_hz = 0.0;  ///< as the scene was loaded
    double touch_decay_s = 0.03;
    double inharmonicity = kInharmonicity;
    double decay_s = 0.0;         ///< of the tone that sounds
    double tone_hz = 0.0;         ///< its pitch
    bool sounds = false;          ///< it sends StringSounding
    std::uint32_t number = 0;     ///< of the last of these
    std::int64_t told_ns = 0;     ///< its instant
    double told_amplitude = 0.0;  ///< of what it says since the tone, m; 0: nothing yet
    double told_decay_s = 0.0;
    const ToneFile* recording = nullptr;
  };

  void play_tone(const v1::Tone& tone, std::int64_t due_ns);
  void play_radius(const v1::StringRadius& radius, std::int64_t due_ns);
  void play_sounding(const v1::StringSounding& sounding, std::int64_t due_ns);
  [[nodiscard]] static bool is_news(const v1::StringSounding& sounding, const String& string);
  /// Begins a tone that nobody has released: a string that was struck, or let go by a stop.
  void begin_sounding(const v1::StringSounding& sounding, std::int64_t due_ns);
  void strike(const ToneSound& tone, String& string, std::int64_t due_ns);
  [[nodiscard]] Bend bend_to(const v1::StringSounding& sounding, const String& string) const;
  [[nodiscard]] double keep_of(const String& string, double decay_s) const;
  [[nodiscard]] std::optional<Strike> strike_of(const ToneSound& tone, const String& string) const;
  String& string_at(std::uint32_t index);
  void submit(const Order& order);

  Sound sound_;
  ToneFiles* tones_;
  Submit submit_;
  double reference_m_ = 5e-3;  ///< amplitude of level 1
  std::vector<String> strings_;
  EventCounts counts_;
};

}  // namespace hapticd::audio
