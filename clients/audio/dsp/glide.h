// How far the pitch of a tone is from the one that it is made for: ln(f / f_end) = g exp(-t / T),
// as Tone.glide_* say, and from the first StringSounding on in straight ways of ln f, as these say.
// Evaluated every kGlideStep frames of the tone's age, so that the block size of the sound card
// does not matter. RT: yes, no libm.
#pragma once

#include <array>

namespace hapticd::audio {

/// Frames between two evaluations; between them the delay of a string goes in a straight line.
inline constexpr int kGlideStep = 16;
/// A glide smaller than this has ended: 0.0002 cents. Larger, and the end would be heard as a step.
inline constexpr double kGlideEnd = 1e-7;

/// Furthest that a pitch is bent, as a logarithm: three octaves either way.
inline constexpr double kMaxBend = 2.08;

/// exp(x) for x within kMaxBend, to 1e-11: Taylor's series, degree 11, of a quarter of it.
[[nodiscard]] constexpr double pitch_ratio(double x) noexcept {
  double sum = 1.0;
  for (int n = 11; n > 0; --n) sum = 1.0 + 0.25 * x * sum / n;
  return (sum * sum) * (sum * sum);
}

/// A straight way of ln f.
struct GlideWay {
  double step = 0.0;  ///< per kGlideStep frames
  int steps = 0;
};

/// Where a pitch goes: to `goal` (ln(f / f_end)) in `approach` steps, then on along `onward`.
struct Bend {
  double goal = 0.0;
  int approach = 1;
  GlideWay onward;
};

/// State of one glide.
struct Glide {
  double size = 0.0;               ///< ln(f / f_end) now
  double keep = 1.0;               ///< its factor per kGlideStep frames
  std::array<GlideWay, 2> ways{};  ///< gone before it keeps anything

  [[nodiscard]] constexpr bool active() const noexcept {
    return ways[0].steps > 0 || ways[1].steps > 0 || (size > 0.0 && keep < 1.0);
  }
  [[nodiscard]] constexpr double ratio() const noexcept { return pitch_ratio(size); }
  constexpr void advance() noexcept {
    for (GlideWay& way : ways) {
      if (way.steps <= 0) continue;
      --way.steps;
      size += way.step;
      return;
    }
    size *= keep;
    if (keep < 1.0 && size < kGlideEnd) size = 0.0;
  }
  /// From now on it goes where `bend` says. approach >= 1.
  constexpr void follow(const Bend& bend) noexcept {
    keep = 1.0;
    ways = {GlideWay{(bend.goal - size) / bend.approach, bend.approach}, bend.onward};
  }
};

}  // namespace hapticd::audio
