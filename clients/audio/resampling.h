// A sound at another sample rate: the band-limited interpolation of J. O. Smith and P. Gossett, "A
// flexible sampling-rate conversion method" (ICASSP 1984), with a Kaiser window. Places are kept as
// whole numbers, so the pitch is exact however long the sound is. To 0.9 of the lower Nyquist
// frequency the gain is 1 within 1e-4, beyond that Nyquist frequency what would alias is below
// -100 dB. Cost: 160 operations per frame, more by the ratio where the rate goes down. Not RT.
#pragma once

#include <span>
#include <vector>

namespace hapticd::audio {

/// `samples` at `from_hz` as samples at `to_hz`, both in [1, 1e6], over the same time and in phase:
/// the first is at the same instant. Outside of the sound there is silence. Equal rates: a copy.
[[nodiscard]] std::vector<float> resampled(std::span<const float> samples, int from_hz, int to_hz);

}  // namespace hapticd::audio
