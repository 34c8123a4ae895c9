// The last stage before the output: whatever comes, what leaves is a number within [-1, 1]. Up to a
// threshold it is what came, bit for bit. Above, the gain goes down with a smooth knee at once, so
// that no frame passes the bound, and comes back slowly, so that a loud chord is made softer rather
// than cut off. No look-ahead: it delays nothing. RT: yes, 10 operations per frame.
#pragma once

#include <cstdint>

namespace hapticd::audio {

/// Below this the limiter does nothing. Seven open strings of level 1 plucked at once stay below
/// it.
inline constexpr double kLimiterThreshold = 0.9;
/// Share of what is missing of the gain that comes back per frame: 0.2 s at 48 kHz. Faster, and a
/// low string would be distorted within its period.
inline constexpr double kLimiterRecovery = 1.0 / 9600.0;
/// Beyond this a signal is a mistake, not a sound: 120 dB above full scale.
inline constexpr double kAbsurd = 1e6;

/// A number that can be a sound. False for NaN and infinities.
[[nodiscard]] constexpr bool is_sound(double value) noexcept {
  return value < kAbsurd && value > -kAbsurd;
}

class Limiter {
 public:
  /// The frame that leaves for one that comes; 0 for one that is not sound.
  [[nodiscard]] float next(double in) noexcept;
  /// Frames that were made softer.
  [[nodiscard]] std::uint64_t limited() const noexcept { return limited_; }

 private:
  double gain_ = 1.0;
  std::uint64_t limited_ = 0;
};

}  // namespace hapticd::audio
