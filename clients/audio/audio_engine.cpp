// See audio_engine.h.
#include "clients/audio/audio_engine.h"

namespace hapticd::audio {

void AudioEngine::render(const FrameClock& clock, std::int64_t first_frame, std::span<float> out,
                         MidiEvents& notes) noexcept {
  while (timeline_.has_room() && ring_.pop(taken_)) timeline_.add(taken_);
  timeline_.render(clock, first_frame, out, notes);
}

}  // namespace hapticd::audio
