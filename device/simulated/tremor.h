// Physiological tremor as a sum of sinusoids around a centre frequency, three axes, phases and
// frequencies from a seed. Phases are whole numbers of 2^-64 turns, so that they never lose
// precision however long it runs. The same seed gives the same bits with every compiler. RT: yes.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

class Tremor {
 public:
  /// At rest: value() is zero.
  Tremor() = default;

  /// `rms` of the three axes together, m; centre `frequency`, Hz; values are asked for every
  /// `period` s.
  Tremor(std::uint64_t seed, double rms, double frequency, double period) noexcept;

  /// Displacement at the next instant, m.
  HD_REALTIME Vector3 next() noexcept;

 private:
  /// Sinusoids per axis: enough to be no beat, few enough to be cheap.
  static constexpr std::size_t kSinusoids = 4;
  struct Oscillator {
    std::uint64_t phase = 0;
    std::uint64_t increment = 0;
  };
  std::array<std::array<Oscillator, kSinusoids>, 3> axes_{};
  double amplitude_ = 0.0;
};

}  // namespace hapticd
