// A device that a computed hand holds: what the hand is asked to do, pose by pose, and what tells
// it so. Frame: D. SI, times in ns. RT: the calls of GestureHand, yes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

/// How the arm holds the device; the numbers are those of proto Arm.
enum class ArmKind : std::uint8_t {
  kOff = 1,          ///< nobody holds it: the plant alone
  kLight = 2,        ///< a relaxed hand
  kFirm = 3,         ///< a stiff grip
  kAdversarial = 4,  ///< pushes along with the force it felt
};

/// Where the tool should be: X_DH.
struct GesturePoint {
  Array3 p_DH{};                    ///< m
  Array4 q_DH{1.0, 0.0, 0.0, 0.0};  ///< unit
};

/// A motion to a point and a rest there.
struct GestureLeg {
  GesturePoint point;
  std::int64_t duration_ns = 0;  ///< of the motion, >= 0; of the first leg ignored
  std::int64_t hold_ns = 0;      ///< of the rest, >= 0
  bool linear = false;           ///< at constant speed, else minimum jerk
};

/// What one tool does: legs, or samples at a fixed rate. Views memory of its owner.
struct GestureTrack {
  std::span<const GestureLeg> legs;
  std::span<const GesturePoint> samples;
  double rate = 0.0;  ///< of the samples, Hz

  [[nodiscard]] bool empty() const noexcept { return legs.empty() && samples.empty(); }
};

/// Owner of a track.
struct GestureMotion {
  std::vector<GestureLeg> legs;
  std::vector<GesturePoint> samples;
  double rate = 0.0;  ///< Hz

  [[nodiscard]] GestureTrack track() const noexcept { return {legs, samples, rate}; }
};

/// How far a gesture is.
struct GestureProgress {
  bool playing = false;
  float fraction = 0.0F;       ///< of this repetition, 0 on the way to its beginning
  std::uint32_t finished = 0;  ///< repetitions
};

/// The loop's thread calls all of it.
class GestureHand {
 public:
  /// The arm follows `track`, whose memory must stay until the next play, or until gesture() says
  /// it is over; with the arm off the handle stays free. `repeat` = 0: until told otherwise.
  HD_REALTIME virtual void play(const GestureTrack& track, std::uint32_t repeat) noexcept = 0;

  /// The arm rests where it is.
  HD_REALTIME virtual void stop_gesture() noexcept = 0;

  [[nodiscard]] HD_REALTIME virtual GestureProgress gesture() const noexcept = 0;

  /// Another arm takes the handle where it is; kOff where `kind` is none that is known.
  HD_REALTIME virtual void set_arm(ArmKind kind) noexcept = 0;

  /// Restarts the tremor.
  HD_REALTIME virtual void set_seed(std::uint64_t seed) noexcept = 0;

  /// Where a number of the device is not finite, or the handle farther away than any sample may be
  /// (kMaxSamplePosition), puts all of it back to the beginning: the handle at rest where it began,
  /// no gesture, motors without force. False, and nothing done, where all is sound.
  HD_REALTIME virtual bool recover() noexcept = 0;

 protected:
  GestureHand() = default;
  GestureHand(const GestureHand&) = default;
  GestureHand& operator=(const GestureHand&) = default;
  ~GestureHand() = default;
};

}  // namespace hapticd
