// What happened to strings in a tick, at the instant it happened inside the tick. RT: plain data,
// trivially copyable.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/fixed_vector.h"
#include "core/math/limits.h"
#include "core/math/vector.h"

namespace hapticd {

enum class StringEventKind : std::uint8_t {
  kTouch,     ///< a tool begins to touch the string, or the envelope it vibrates in (ringing)
  kPress,     ///< the touch is armed: letting go plucks the string
  kLeave,     ///< the touch ends without having been armed
  kRelease,   ///< an armed touch ends: plucked
  kTone,      ///< it sounds; one per release
  kRadius,    ///< the drawn radius follows another law from now on
  kSounding,  ///< what it sounds like from now on; newest wins
};

/// Why a string is told of anew.
enum class SoundingCause : std::uint8_t { kOnset, kGlide, kTouch, kLift, kDecay };

/// Partials that are told of what a string sounds like, at most.
inline constexpr std::size_t kMaxPartials = 12;

/// What the drawn radius does: R + delta while pressed, R + r_max exp(-(t - t_ns) / decay) after.
enum class RadiusPhase : std::uint8_t { kPress, kRelease, kDamp };

/// Fields that a kind does not name are 0.
struct StringEvent {
  std::int64_t t_ns = 0;    ///< the instant, ns
  std::int32_t string = 0;  ///< index in the scene
  StringEventKind kind = StringEventKind::kTouch;
  RadiusPhase radius_phase = RadiusPhase::kPress;  ///< kRadius
  bool ringing = false;                            ///< kTouch: it was vibrating
  double lambda = 0.0;                             ///< all but kRadius
  double normal_speed = 0.0;      ///< kTouch, kLeave, kRelease, kTone: tool against string, m/s
  double tangential_speed = 0.0;  ///< the same kinds, m/s
  double force = 0.0;  ///< kTouch, kPress: in this tick; kLeave, kRelease: largest of the touch, N
  double deflection = 0.0;   ///< kPress, kRelease (last one before), kRadius: delta, m
  double amplitude = 0.0;    ///< kTone: left ringing at lambda; kRadius: r_max, m
  double level = 0.0;        ///< kTone: loudness in [0, 1]
  double frequency = 0.0;    ///< kTone, kRadius: Hz, once the glide is over
  double decay = 0.0;        ///< kTone, kRadius: T_d, s
  double glide_cents = 0.0;  ///< kTone: pitch above frequency at the onset
  double glide_decay = 0.0;  ///< kTone: decay time of the glide, s
  int partial_count = 0;     ///< kTone: entries of partials; 0 where no modes are modelled
  /// kTone: amplitudes of the modes relative to the largest, in [0, 1].
  std::array<float, kMaxModes> partials{};
  // kSounding: frequency, partial_count, partials (m) as above, and
  SoundingCause cause = SoundingCause::kOnset;
  std::uint32_t number = 0;                  ///< of the message, per string
  double lambda_to = 1.0;                    ///< its part begins at lambda and ends here
  double cents_per_s = 0.0;                  ///< its pitch glides
  double inharmonicity = 0.0;                ///< B of the part
  std::array<float, kMaxPartials> decays{};  ///< of each partial, s
  std::array<float, kMaxPartials> phases{};  ///< rad, kOnset alone
  /// Whose touch it is; -1: no tool's. Of what rings: of the tool that played it.
  std::int32_t tool = -1;
  std::int32_t part = -1;  ///< of that tool; -1: none was near
  Array3 p_WC{};           ///< kTouch, kLeave, kRelease: on the tool's surface, m
  Array3 nhat_OG_W{};      ///< the same kinds: unit, from string to tool
};

/// Events of one tick, in order of their instants within a string; overflow is counted.
using StringEvents = FixedVector<StringEvent, kMaxStringEvents>;

}  // namespace hapticd
