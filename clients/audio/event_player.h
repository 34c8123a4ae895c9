// Turns the daemon's events into orders for the audio engine: a Tone into a strike, a
// StringSounding into the pitch and the partials that its string goes to, and for strings that send
// none a StringRadius into the damping of one that a finger touches, or its end. How loud a metre
// is the Tone says; all that is told counts against that, whatever came before. What was told
// before the player came is repeated in States: a string that rings is begun from there. Knows the
// scene, for the strings' names and stiffness, and the recordings. Instants are given by the
// caller. Not RT.
#pragma once

#include <cstdint>
#include <functional>
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
    double open_decay_s = 0.5;  ///< as the scene was loaded
    double decay_s = 0.0;       ///< of the tone that sounds
    double most_m = 0.0;        ///< what is told counts up to here
    double gain = 0.0;          ///< of its partials; 0: nothing has said it yet
    double per_metre = 0.0;
    bool released = false;    ///< it has had a Tone
    bool sounds = false;      ///< it sends StringSounding
    bool silent = true;       ///< as the last of these says
    v1::StringSounding told;  ///< the last of these
    std::int64_t told_due_ns = 0;
    const ToneFile* recording = nullptr;
  };

  void play_tone(const v1::Tone& tone, std::int64_t due_ns);
  void play_radius(const v1::StringRadius& radius, std::int64_t due_ns);
  void play_sounding(const v1::StringSounding& sounding, std::int64_t due_ns);
  [[nodiscard]] static bool is_news(const v1::StringSounding& sounding, const String& string);
  /// Orders what the string was told last, as it goes on until due_ns.
  void tell(String& string, std::int64_t due_ns);
  /// How loud a metre is where no Tone has said it: a string that was struck, or let go by a stop.
  /// False where its pitch cannot be played.
  [[nodiscard]] bool set_loudness(String& string) const;
  void strike(const ToneSound& tone, String& string, std::int64_t due_ns);
  [[nodiscard]] Strike strike_of_told(const String& string, double since_s) const;
  [[nodiscard]] Bend bend_to(const v1::StringSounding& sounding, double since_s) const;
  [[nodiscard]] double keep_of(const String& string, double decay_s) const;
  /// Has a strike played by the recording of its string.
  void play_recording(const ToneSound& tone, const String& string, Strike& strike) const;
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
