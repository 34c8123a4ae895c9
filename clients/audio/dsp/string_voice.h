// A plucked string: a single delay loop after H. Penttinen, J. Pakarinen, V. Valimaki, M. Laurson,
// H. Li, M. Leman, "Model-based sound synthesis of the guqin", JASA 120 (2006): fractional delay,
// one-pole loss filter, allpass dispersion, time-varying length.
// Deviation: the string is excited by one period that has the spectrum of the pluck (a comb by the
// place it is plucked at), instead of a recorded residual; the delay is interpolated by a
// polynomial that has no state, so that it may glide without clicks. RT: yes, about 60 operations
// per frame, 250 more in the first period.
#pragma once

#include <array>
#include <cstdint>

#include "clients/audio/dsp/interpolation.h"
#include "clients/audio/dsp/strike.h"

namespace hapticd::audio {

/// State of one string. About 70 kB.
class StringVoice {
 public:
  /// Starts again. Precondition: period at the onset less its filters >= kMinDelay, period <=
  /// kMaxPeriod.
  void start(const Strike& strike) noexcept;
  /// The next frame.
  [[nodiscard]] double next() noexcept;

 private:
  static constexpr std::uint32_t kLine = 8192;
  static_assert(kLine >= kMaxPeriod + kTaps, "the longest period fits");

  [[nodiscard]] double excite() noexcept;
  [[nodiscard]] double delayed() const noexcept;
  [[nodiscard]] double delay_of(double ratio) const noexcept;
  void set_delay(double delay) noexcept;
  void follow_glide() noexcept;

  StringLoop loop_;
  Glide glide_;
  std::array<double, kLine> line_{};
  std::uint32_t now_ = 0;  ///< frames since the start
  double delay_ = 0.0;     ///< of the line, frames
  double delay_step_ = 0.0;
  std::uint32_t whole_ = 0;
  std::array<double, kTaps> weights_{};
  double loss_ = 0.0;
  std::array<double, kMaxSections> section_in_{};
  std::array<double, kMaxSections> section_out_{};

  std::uint32_t excitation_frames_ = 0;
  int partials_ = 0;
  std::array<double, kMaxPartials> sine_{};    ///< amplitude sin(n theta k)
  std::array<double, kMaxPartials> before_{};  ///< the same at k - 1
  std::array<double, kMaxPartials> turn_{};    ///< 2 cos(n theta)
};

}  // namespace hapticd::audio
