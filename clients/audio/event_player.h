// Turns the daemon's events into orders for the audio engine: a Tone into a strike, a StringRadius
// into the damping of a string that a finger touches, or its end. Knows the scene, for the strings'
// names and stiffness, and the recordings. Instants are given by the caller. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/audio/dsp/timeline.h"
#include "clients/audio/string_design.h"
#include "clients/audio/tone_files.h"
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
  /// An event, to be heard at due_ns. Anything but Tone and StringRadius is left alone.
  void play(const v1::Item& event, std::int64_t due_ns);

  [[nodiscard]] const EventCounts& counts() const noexcept { return counts_; }

 private:
  struct String {
    std::string name;
    double frequency_hz = 0.0;  ///< as the scene was loaded
    double touch_decay_s = 0.03;
    double inharmonicity = kInharmonicity;
    double decay_s = 0.0;  ///< of the tone that sounds
    const ToneFile* recording = nullptr;
  };

  void play_tone(const v1::Tone& tone, std::int64_t due_ns);
  void play_radius(const v1::StringRadius& radius, std::int64_t due_ns);
  [[nodiscard]] std::optional<Strike> strike_of(const ToneSound& tone, const String& string) const;
  String& string_at(std::uint32_t index);
  void submit(const Order& order);

  Sound sound_;
  ToneFiles* tones_;
  Submit submit_;
  std::vector<String> strings_;
  EventCounts counts_;
};

}  // namespace hapticd::audio
