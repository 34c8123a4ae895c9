// A string from the first press to the last ring: the modes of string_motion.h, pressed by the
// tools through the contacts of string_contacts.h, stepped kSubSteps times a millisecond, or
// as often as the scene says. What it rings with after a pluck is what the finger left in it. A
// string that nothing touches is not stepped: it is turned on in closed form when somebody asks.
//
// A tool meets it through what it is held by. While it plucks, the contact is a spring as soft as
// the tool's coupling between the string and where the tool would be without it (soft); once the
// hand has held still for a while the tool itself, with the stiffness of a finger (firm): a held
// finger has mass, and through the coupling alone a stop would sound flat. In both the string at
// rest bears just the force of the static law. SI; across the string, (y, z). RT: yes.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/instrument/instrument_options.h"
#include "core/instrument/string_contacts.h"
#include "core/instrument/string_parameters.h"
#include "core/instrument/string_touch.h"
#include "core/instrument/wave_rest.h"

namespace hapticd {

/// What the modes of a string are made from.
struct WaveTuning {
  double length = 0.0;         ///< m
  double tension = 0.0;        ///< with what bends it adds, N
  double frequency = 0.0;      ///< at that tension, Hz; 0: it has no modes
  double modal_mass = 0.0;     ///< kg
  double inharmonicity = 0.0;  ///< at that tension
  double decay = 0.5;          ///< s
  double loss_n2 = 0.0;        ///< 1/s
  int modes = 0;               ///< asked for
  int substeps = kSubSteps;    ///< of a millisecond

  bool operator==(const WaveTuning&) const = default;
};

/// The tuning of `string` where its tension is `tension` (N, > 0) now.
[[nodiscard]] HD_REALTIME WaveTuning tuning_at(const StringConstants& string, double tension,
                                               const InstrumentOptions& options) noexcept;

/// A tool that presses the string, or that the string may meet while it swings, over a tick.
struct WaveTouch {
  double lambda_before = 0.5;
  double lambda = 0.5;       ///< place along the string at the end
  Transverse centre_before;  ///< of its sphere at the start, m; used where it was not near before
  /// At the end, m. While it presses: where the string at rest, bent by `force`, lies `radius`
  /// from it.
  Transverse centre;
  double radius = 0.0;           ///< of sphere and string together, m, > 0
  Transverse normal;             ///< unit, from the string to it
  double force = 0.0;            ///< of the static law along the normal, N, >= 0
  Transverse law;                ///< all of it on the tool, friction included, N
  double compliance = 1e-3;      ///< of what holds it, along the normal, m/N, > 0
  double part_compliance = 0.0;  ///< of that, what its soft parts yield, m/N
  double part_damping = 0.0;     ///< and how they damp, N s/m
  Transverse part_aside;         ///< where they stand aside of where the tool has them, m
  double hand_speed = 0.0;       ///< of the hand there, across the string, m/s
};

/// One tool's contact, from tick to tick.
struct WaveContact {
  bool near = false;  ///< it was in the last tick
  bool firm = false;
  StringContactPath path;  ///< `force` is the mean of the last tick
  Transverse centre;       ///< of the sphere where it stands, m
  double reach = 0.0;      ///< its radius, m
  Transverse push;         ///< of the static law on it, along the normal, N
  double lacking = 0.0;    ///< what its radius is short of, for it began inside, m
  double held = 0.0;       ///< in touch so long, s
  double speed = 0.0;      ///< of the hand, mean of some 10 ms, m/s
  double astray = 0.0;     ///< the static law has pressed and the string not, so long, s
  Transverse load;         ///< force on the string, mean of some 5 ms, N
};

/// State of a string.
struct WaveString {
  WaveTuning tuning;
  int count = 0;  ///< modes that it has
  ModalMotion motion;
  std::int64_t done_ns = 0;  ///< it has been stepped to here
  std::array<WaveContact, kMaxTools> contacts;
  WaveRests rests;
};

static_assert(kMaxTools + kMaxWaveRests <= static_cast<std::size_t>(kMaxStringContacts));

/// The table of a tuning. Never part of a snapshot.
struct WaveTable {
  WaveTuning of;
  ModeTable modes;
};

/// What one tick did.
struct WaveTick {
  int steps = 0;             ///< that were made
  std::int64_t from_ns = 0;  ///< where they begin
  std::int64_t step_ns = 0;  ///< of one, ns
  int fallbacks = 0;         ///< of play()
};

/// Length of a sub-step in time, ns.
[[nodiscard]] constexpr std::int64_t step_ns(const WaveTuning& tuning) noexcept {
  return 1'000'000 / tuning.substeps;
}

/// At rest from t_ns on.
HD_REALTIME void rest(std::int64_t t_ns, WaveString& string) noexcept;

/// Takes another tuning, which leaves every displacement and every speed as it is.
HD_REALTIME void retune(const WaveTuning& tuning, WaveTable& table, WaveString& string) noexcept;

/// Turns a string that nothing touches on to t_ns. 1 us; as many sub-steps as fit.
HD_REALTIME void turn_to(std::int64_t t_ns, const WaveTable& table, WaveString& string) noexcept;

/// What a string is stepped by; views.
struct WaveModel {
  const StringConstants& string;
  const InstrumentOptions& options;
  const WaveTable& table;
  std::span<const WaveRestTouch> rests{};  ///< that it may meet in the tick
};

/// Steps the string to the end of the tick under `touches`, one per tool, null: not near. 3.5 us
/// with one; a pause longer than kMaxElapsed turns it on without them first.
HD_REALTIME WaveTick step(const WaveModel& model, const TickTime& time,
                          std::span<const WaveTouch* const> touches, WaveString& state) noexcept;

/// What it does about what its contacts hold it bent to. 0.3 us, and as much a contact.
[[nodiscard]] HD_REALTIME ModalMotion ringing_motion(const WaveTable& table,
                                                     const WaveString& string) noexcept;

/// Energy of that, J.
[[nodiscard]] HD_REALTIME double ringing_energy(const WaveTable& table,
                                                const WaveString& string) noexcept;

/// No point at lambda swings further than this with `energy` (J) in all, m.
[[nodiscard]] HD_REALTIME double reach_of(const WaveTuning& tuning, double energy,
                                          double lambda) noexcept;

}  // namespace hapticd
