// What the wooden body makes of the strings: their sound as it is and six resonances beside it,
// each a band-pass of two poles (R. Bristow-Johnson's constant peak form). Its response is linear
// and the same for all strings, so it is computed once for their sum. RT: yes, 40 operations per
// frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapticd::audio {

inline constexpr std::size_t kBodyModes = 6;

/// One resonance: b (1 - z^-2) / (1 + a1 z^-1 + a2 z^-2).
struct BodyMode {
  double b = 0.0;
  double a1 = 0.0;
  double a2 = 0.0;
};

/// Coefficients, made by body_design.h.
struct BodyFilter {
  std::array<BodyMode, kBodyModes> modes{};
};

/// Its state.
class Body {
 public:
  explicit Body(const BodyFilter& filter) noexcept : filter_(filter) {}
  /// The next frame of its sound, for that of the strings.
  [[nodiscard]] double next(double strings) noexcept;
  /// As if nothing had sounded yet.
  void forget() noexcept { *this = Body(filter_); }

 private:
  /// A resonance that has died away is made exactly 0, since numbers below 1e-308 are slow.
  void settle() noexcept;

  struct State {
    double out_1 = 0.0;
    double out_2 = 0.0;
  };
  BodyFilter filter_;
  std::uint32_t age_ = 0;
  double in_1_ = 0.0;
  double in_2_ = 0.0;
  std::array<State, kBodyModes> states_{};
};

}  // namespace hapticd::audio
