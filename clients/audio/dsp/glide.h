// How far the pitch of a tone is above where it ends: ln(f / f_end) = g exp(-t / T), as
// Tone.glide_* say. Evaluated every kGlideStep frames of the tone's age, so that the block size of
// the sound card does not matter. RT: yes, no libm.
#pragma once

namespace hapticd::audio {

/// Frames between two evaluations; between them the delay of a string goes in a straight line.
inline constexpr int kGlideStep = 16;
/// A glide smaller than this has ended: 0.0002 cents. Larger, and the end would be heard as a step.
inline constexpr double kGlideEnd = 1e-7;

/// exp(x) for x in [0, ln 2], to 2e-12: Taylor's series, degree 11.
[[nodiscard]] constexpr double pitch_ratio(double x) noexcept {
  double sum = 1.0;
  for (int n = 11; n > 0; --n) sum = 1.0 + x * sum / n;
  return sum;
}

/// State of one glide.
struct Glide {
  double size = 0.0;  ///< ln(f / f_end) now
  double keep = 1.0;  ///< its factor per kGlideStep frames

  [[nodiscard]] constexpr bool active() const noexcept { return size > 0.0; }
  [[nodiscard]] constexpr double ratio() const noexcept { return pitch_ratio(size); }
  constexpr void advance() noexcept {
    size *= keep;
    if (size < kGlideEnd) size = 0.0;
  }
};

}  // namespace hapticd::audio
