// All tones that sound: a fixed number of voices, each a computed string, a string's partials
// one by one, or a recording; the body, and the limiter behind them. A voice whose output is no
// longer a number is ended. The result does not depend on how the frames are divided into calls.
// RT: yes; no heap, the object itself is 2 MB and belongs on the heap of its owner.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "clients/audio/dsp/body.h"
#include "clients/audio/dsp/limiter.h"
#include "clients/audio/dsp/partial_bank.h"
#include "clients/audio/dsp/recorded_voice.h"
#include "clients/audio/dsp/strike.h"
#include "clients/audio/dsp/string_voice.h"

namespace hapticd::audio {

/// Tones that sound at once. One more, and the faintest ends for it.
inline constexpr std::size_t kVoices = 32;

class Synthesizer {
 public:
  explicit Synthesizer(const BodyFilter& body) noexcept : body_(body) {}

  /// A tone begins with the next frame; an older one of the same string is choked.
  void start(const Strike& strike) noexcept;
  /// From the next frame on a string is damped, or rings freely again.
  void change(const Change& change) noexcept;
  /// From the next frame on the string of `strike` goes to its partials, from whatever it sounds
  /// like. A voice that cannot go there gives way to `strike`. True where nothing sounded and it
  /// begins.
  bool tell(const Strike& strike, const Telling& telling) noexcept;
  /// The next frames, each a number within [-1, 1].
  void render(std::span<float> out) noexcept;

  /// Voices in use.
  [[nodiscard]] std::size_t sounding() const noexcept;
  /// Tones that were ended because there were too many.
  [[nodiscard]] std::uint64_t stolen() const noexcept { return stolen_; }
  /// Tones that were ended because they gave no numbers.
  [[nodiscard]] std::uint64_t broken() const noexcept { return broken_; }
  /// Frames that the limiter made softer.
  [[nodiscard]] std::uint64_t limited() const noexcept { return limiter_.limited(); }

 private:
  enum class Kind : std::uint8_t { kComputed, kPartials, kRecorded };
  struct Voice {
    bool used = false;
    Kind kind = Kind::kComputed;
    std::int32_t string = 0;  ///< kNoString: choked
    double whole = 0.0;       ///< gain that it began with
    double gain = 0.0;        ///< with what damping has left
    double keep = 1.0;        ///< factor on gain per frame
    double ramp = 0.0;        ///< added to `share` per frame
    double share = 1.0;       ///< of the loudness it would have by its gain
    std::int32_t ramps = 0;   ///< frames more that it is added
    std::int64_t left = 0;    ///< frames
    double log_hz = 0.0;      ///< ln of the pitch that it is made for
    ToldPartials began;       ///< its partials when it began
    double loudness = 0.0;    ///< what it has by itself, undamped, m
    double own_keep = 1.0;    ///< factor on that per frame
    StringVoice computed;
    PartialBank partials;
    RecordedVoice recording;
  };

  [[nodiscard]] Voice& free_voice() noexcept;
  Voice& begin(const Strike& strike) noexcept;
  static bool follow(Voice& voice, const Strike& strike, const Telling& telling) noexcept;
  [[nodiscard]] static double sound_of(Voice& voice) noexcept;
  [[nodiscard]] static bool is_over(const Voice& voice) noexcept;
  double next(Voice& voice) noexcept;

  Body body_;
  Limiter limiter_;
  std::array<Voice, kVoices> voices_{};
  std::uint64_t stolen_ = 0;
  std::uint64_t broken_ = 0;
};

}  // namespace hapticd::audio
