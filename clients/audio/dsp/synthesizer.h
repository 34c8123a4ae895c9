// All tones that sound: a fixed number of voices, each a computed string or a recording, the body,
// and the limiter behind them. A voice whose output is no longer a number is ended. The result does
// not depend on how the frames are divided into calls. RT: yes; no heap, the object itself is 2 MB
// and belongs on the heap of its owner.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "clients/audio/dsp/body.h"
#include "clients/audio/dsp/limiter.h"
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
  /// From the next frame on a string is damped, or rings freely again; and its pitch goes
  /// elsewhere.
  void change(const Change& change) noexcept;
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
  struct Voice {
    bool used = false;
    bool recorded = false;
    std::int32_t string = 0;  ///< kNoString: choked
    double gain = 0.0;        ///< with what damping has left
    double keep = 1.0;        ///< factor on gain per frame
    double ramp = 0.0;        ///< added to `share` per frame
    double share = 1.0;       ///< of the loudness it would have by its gain
    std::int32_t ramps = 0;   ///< frames more that it is added
    std::int64_t left = 0;    ///< frames
    StringVoice computed;
    RecordedVoice recording;
  };

  [[nodiscard]] Voice& free_voice() noexcept;
  double next(Voice& voice) noexcept;

  Body body_;
  Limiter limiter_;
  std::array<Voice, kVoices> voices_{};
  std::uint64_t stolen_ = 0;
  std::uint64_t broken_ = 0;
};

}  // namespace hapticd::audio
