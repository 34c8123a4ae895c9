// The first partials of a string as sines: for a string of which the daemon tells each partial, by
// its Tone and by StringSounding, partial n at n f sqrt((1 + B n^2) / (1 + B)) with an amplitude
// and a decay of its own. What is told anew is reached along a smooth way, at amplitudes and pitch
// alike, while the phases run on. RT: yes, 150 operations per frame, no libm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clients/audio/dsp/glide.h"
#include "clients/audio/dsp/strike.h"

namespace hapticd::audio {

/// cos and sin of an angle.
struct Turn {
  double cosine = 1.0;
  double sine = 0.0;
};

/// Of an angle within [-pi, pi], to 1e-15: Taylor's series of a quarter of it, doubled twice.
[[nodiscard]] Turn turn_by(double angle) noexcept;

class PartialBank {
 public:
  /// Starts again, as loud as `strike` says.
  void start(const Strike& strike) noexcept;
  /// From the next frame on it goes to what `told` says, within bend.approach; bend.goal is
  /// relative to the pitch it was started with.
  void tell(const ToldPartials& told, const Bend& bend) noexcept;
  /// What it sounds like by itself becomes `factor` times as loud.
  void scale(double factor) noexcept;
  /// The next frame, as force at the bridge for a gain of 1.
  [[nodiscard]] double next() noexcept;
  /// It was told to be silent, and is.
  [[nodiscard]] bool over() const noexcept { return silent_ && ramp_ >= ramps_; }

 private:
  using PerPartial = std::array<double, kToldPartials>;

  [[nodiscard]] double omega_of(std::size_t n, double ratio) const noexcept;
  void retune() noexcept;
  void advance() noexcept;
  void settle() noexcept;

  Glide glide_;
  double omega_ = 0.0;  ///< of the pitch it was started with, rad per frame
  double per_metre_ = 0.0;
  bool silent_ = false;
  bool turns_ = false;          ///< its pitch changes in this step
  std::int32_t ramp_ = 0;       ///< frames gone of the way to `goal_`
  std::int32_t ramps_ = 0;      ///< of so many
  std::int32_t stretches_ = 0;  ///< steps more in which `number_` changes
  std::uint32_t age_ = 0;
  PerPartial cosine_{}, sine_{};              ///< of its phase
  PerPartial rate_cosine_{}, rate_sine_{};    ///< of what the phase advances per frame
  PerPartial curve_cosine_{}, curve_sine_{};  ///< of what that changes per frame
  PerPartial audible_{};                      ///< 0 where it is too high for the sample rate
  PerPartial number_{}, number_step_{};  ///< its frequency over the first one's; change per step
  PerPartial amplitude_{}, from_{}, goal_{}, keep_{};
};

}  // namespace hapticd::audio
