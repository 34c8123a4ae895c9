// What is kept of a string that sounds from tick to tick beside its motion: whose touch is one,
// what has been told of it, and what it may still give to hands. SI. RT: yes, plain data.
#pragma once

#include <array>
#include <cstdint>

#include "core/instrument/wave_string.h"
#include "core/tick/string_event.h"

namespace hapticd {

/// One tool's touch of a string that sounds: a contact with force.
struct WaveGrip {
  bool touching = false;
  bool armed = false;  ///< letting go plucks
  std::int64_t began_ns = 0;
  std::int64_t felt_ns = 0;       ///< when it last bore force
  std::int64_t pressed_ns = 0;    ///< when the static law pressed last, without it
  double energy_before = 0.0;     ///< of the ringing, when it began, J
  double lambda = 0.5;            ///< of the last force
  double share = 0.0;             ///< of the time with force, mean of some 20 ms
  double deflection = 0.0;        ///< of the static law, last, m
  double largest_force = 0.0;     ///< of the touch, N
  double normal_speed = 0.0;      ///< tool against string, last, m/s
  double tangential_speed = 0.0;  ///< likewise
};

/// What hands may still draw from a string beyond its static law, and what draws.
struct WaveTank {
  double energy = 5e-6;  ///< J
  double let_go = 0.0;   ///< by the static laws, and not yet in it, J, <= 0
  /// Of each tool: force beyond the static law and of the static law that the last tick held, on
  /// the tool, N, and what the static law stored, J.
  std::array<Transverse, kMaxTools> beyond{};
  std::array<Transverse, kMaxTools> law{};
  std::array<double, kMaxTools> pull{};  ///< of the static law along the string, N
  std::array<double, kMaxTools> stored{};
};

/// The envelope that clients draw: `amplitude` (m) at t_ns, falling with `decay` (s).
struct ToldEnvelope {
  std::int64_t t_ns = 0;
  double amplitude = 0.0;
  double decay = 0.0;
};

/// What a client believes of a string.
struct ToldSounding {
  bool sounds = false;
  bool plucked = false;        ///< since it was last looked at
  std::int64_t t_ns = 0;       ///< of what was told
  std::int64_t looked_ns = 0;  ///< when it was last looked at
  std::int64_t paced_ns = 0;   ///< messages at the allowed pace would have come until here
  std::uint32_t number = 0;    ///< of the message
  double from = 0.0;           ///< part of the string, [0, 1]
  double to = 1.0;
  double place = 0.0;      ///< within the part that clients hear, or are to hear
  double frequency = 0.0;  ///< Hz
  double cents_per_s = 0.0;
  double onset = 0.0;                            ///< amplitude of the loudest so far, m
  std::array<double, 2> pitch{};                 ///< of `place` before now, and before that, Hz
  std::array<std::int64_t, 2> pitch_ns{};        ///< when
  std::array<double, kMaxPartials> amplitude{};  ///< m
  std::array<double, kMaxPartials> decay{};      ///< s
  std::array<double, kMaxPartials> heard{};      ///< amplitudes when it was last looked at, m
};

/// All that goes from tick to tick of one string.
struct WaveState {
  bool awake = false;
  bool stepped = false;     ///< in the last tick: somebody is near
  bool sounded = false;     ///< a release has sounded, at sounded_ns
  std::int32_t player = 0;  ///< the tool that touched it last
  std::int64_t sounded_ns = 0;
  double ringing = 0.0;  ///< energy about what holds it, J, at string.done_ns
  double stored = 0.0;   ///< energy of all of it, J, likewise
  WaveString string;
  double released = 0.0;      ///< the ringing at the last release, J
  double held_tension = 0.0;  ///< of the tuning, without what its swinging adds, N
  std::array<WaveGrip, kMaxTools> grips;
  WaveTank tank;
  ToldEnvelope told;
  ToldSounding sounding;
};

/// One string with what is made from its state.
struct WaveMemory {
  WaveState state;
  WaveTable table;
};

}  // namespace hapticd
