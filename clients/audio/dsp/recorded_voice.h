// Plays a recorded tone, at the pitch of the event: the recording is read faster or slower,
// interpolated between its samples. At its own pitch its samples come out as they are. RT: yes, 20
// operations per frame.
#pragma once

#include <cstdint>

#include "clients/audio/dsp/strike.h"

namespace hapticd::audio {

class RecordedVoice {
 public:
  /// Starts again. strike.recorded.samples is not null.
  void start(const Strike& strike) noexcept;
  /// The next frame; 0 beyond the end.
  [[nodiscard]] double next() noexcept;
  /// Its pitch goes there from now on.
  void follow(const Bend& bend) noexcept { glide_.follow(bend); }
  /// The recording is over.
  [[nodiscard]] bool over() const noexcept {
    return place_ >= static_cast<double>(recorded_.frames);
  }

 private:
  RecordedTone recorded_;
  Glide glide_;
  double place_ = 0.0;  ///< in the recording, frames
  double step_ = 1.0;
  std::uint32_t age_ = 0;
};

}  // namespace hapticd::audio
