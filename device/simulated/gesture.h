// The player that walks along a gesture: what the arm is asked to do, pose by pose. Way-points are
// joined by minimum-jerk motions (Flash and Hogan, "The coordination of arm movements", Journal of
// Neuroscience 5, 1985: s = 10 t^3 - 15 t^4 + 6 t^5) or at constant speed; rotations go about one
// axis. A gesture begins with such a motion from wherever the target is. SI, times in ns. RT: the
// player, yes.
#pragma once

#include <cstdint>

#include "core/math/pose.h"
#include "core/math/realtime.h"
#include "device/api/gesture_hand.h"

namespace hapticd {

/// Length of one repetition without the way to its beginning, ns.
[[nodiscard]] std::int64_t duration_ns(const GestureTrack& track) noexcept;

/// Peak speed of the way to the beginning of a gesture, m/s and rad/s, and its shortest time, ns.
/// Normal values 0.3, 2, 300 ms; faster would jerk a held hand.
inline constexpr double kApproachSpeed = 0.3;
inline constexpr double kApproachTurn = 2.0;
inline constexpr std::int64_t kMinApproach_ns = 300'000'000;
/// Peak over mean speed of a minimum-jerk motion.
inline constexpr double kMinimumJerkPeak = 1.875;

/// Walks along a track.
class GesturePlayer {
 public:
  /// The target rests at `X_DH`.
  explicit GesturePlayer(const Pose& X_DH) noexcept : target_(X_DH) {}

  /// Begins `track`, whose memory must stay until the next play, or until progress() says it is
  /// over. `repeat` = 0: until told otherwise. An empty track ends the current one.
  HD_REALTIME void play(const GestureTrack& track, std::uint32_t repeat) noexcept;

  /// Ends what plays; the target rests where it is.
  HD_REALTIME void stop() noexcept { playing_ = false; }

  /// Ends what plays and puts the target somewhere.
  HD_REALTIME void rest_at(const Pose& X_DH) noexcept;

  /// Lets `dt_ns` pass and returns the target X_DH.
  HD_REALTIME const Pose& advance(std::int64_t dt_ns) noexcept;

  [[nodiscard]] const Pose& target() const noexcept { return target_; }
  [[nodiscard]] GestureProgress progress() const noexcept;

 private:
  enum class Phase : std::uint8_t { kApproach, kTrack };
  /// The motion under way: from X along a chord and a rotation vector.
  struct Motion {
    Pose from;
    Vector3 chord{0.0, 0.0, 0.0};
    Vector3 turn{0.0, 0.0, 0.0};
    std::int64_t duration_ns = 0;
    bool linear = false;
  };
  void begin_motion(const GesturePoint& to, std::int64_t duration_ns, bool linear) noexcept;
  void begin_repetition() noexcept;
  void end_repetition() noexcept;
  /// Ends the leg under way and begins the next; false at the end of the track.
  bool next_leg() noexcept;
  void walk_legs() noexcept;
  void walk_samples() noexcept;
  [[nodiscard]] Pose along(double share) const noexcept;

  GestureTrack track_;
  Motion motion_;
  Pose target_;
  std::int64_t total_ns_ = 0;
  std::int64_t done_ns_ = 0;  ///< of this repetition, legs that are over
  std::int64_t into_ns_ = 0;  ///< into the leg, or the samples, under way
  std::size_t leg_ = 0;
  std::uint32_t repeat_ = 0;
  std::uint32_t finished_ = 0;
  Phase phase_ = Phase::kApproach;
  bool playing_ = false;
};

}  // namespace hapticd
