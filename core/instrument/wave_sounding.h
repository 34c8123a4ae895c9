// What clients are told of a string that sounds, so that they can go on by themselves: its part,
// pitch, how that glides, and its partials with their decays. The same extrapolation runs here, and
// what is told is told anew where it has come to err: by more than 1.5 cents, 1 dB in all, or 3 dB
// in a partial that is heard, a hundred times a second at most and no sooner than after 5 ms. So a
// steady tone is a few messages, and a glide as many as it needs. SI. RT: yes; 10 us every 4 ms
// while somebody touches the string.
#pragma once

#include "core/instrument/wave_watch.h"

namespace hapticd {

/// Cents of pitch that told glides are followed for, s: afterwards clients hold it.
inline constexpr double kGlideFollowed = 0.1;

/// Looks at the string at t_ns. `steady`: nobody is near, so it goes on in closed form.
HD_REALTIME void watch_sounding(const WatchedWave& wave, std::int64_t t_ns, bool steady,
                                StringEvents& events) noexcept;

/// Says that it is silent.
HD_REALTIME void end_sounding(const WatchedWave& wave, std::int64_t t_ns,
                              StringEvents& events) noexcept;

}  // namespace hapticd
