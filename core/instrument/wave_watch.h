// The events of a string that sounds, read off its state: a touch is a contact with force, and a
// tone what an armed one leaves when it is gone. RT: yes, 50 ns per tool; 10 us for a tone.
#pragma once

#include "core/instrument/instrument_options.h"
#include "core/instrument/wave_state.h"
#include "core/tick/string_event.h"

namespace hapticd {

/// A string that sounds, with what its events go by.
struct WatchedWave {
  std::int32_t index;  ///< its number, for its events
  const StringConstants& string;
  const InstrumentOptions& options;
  const WaveTable& table;
  WaveState& state;
};

/// What the static law says of a tool's touch in a tick.
struct WaveGripTick {
  std::size_t tool = 0;
  bool pressed = false;           ///< it bears force by the static law
  double deflection = 0.0;        ///< m
  double normal_speed = 0.0;      ///< tool against string, m/s
  double tangential_speed = 0.0;  ///< m/s
};

/// Watches the touch of one tool over the tick that was stepped; state.ringing and state.stored are
/// as of its end.
HD_REALTIME void watch_grip(const WatchedWave& wave, const WaveTick& tick, const WaveGripTick& grip,
                            StringEvents& events) noexcept;

/// Tells the envelope again where what was told is off by a tenth.
HD_REALTIME void watch_envelope(const WatchedWave& wave, std::int64_t t_ns,
                                StringEvents& events) noexcept;

/// The string falls asleep: it is drawn straight.
HD_REALTIME void tell_silence(const WatchedWave& wave, std::int64_t t_ns,
                              StringEvents& events) noexcept;

}  // namespace hapticd
