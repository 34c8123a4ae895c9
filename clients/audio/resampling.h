// A sound at another sample rate, by libsamplerate's best sinc converter. To 0.9 of the lower
// Nyquist frequency a sine stays itself within -100 dB, and what would alias is below that. Not RT.
#pragma once

#include <span>
#include <vector>

namespace hapticd::audio {

/// `samples` at `from_hz` as samples at `to_hz`, both in [1, 1e6], over the same time and in phase:
/// the first is at the same instant. Outside of the sound there is silence. Equal rates: a copy.
/// Throws std::runtime_error where a rate is more than 256 times the other.
[[nodiscard]] std::vector<float> resampled(std::span<const float> samples, int from_hz, int to_hz);

}  // namespace hapticd::audio
