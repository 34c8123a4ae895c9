// Where a string that sounds meets what it lies on (string_rests.h): frets in reach of its swing,
// and the board under a finger. Frames: W. SI. RT: yes, nothing where a scene has no rests.
#pragma once

#include "core/simulation/wave_meeting.h"

namespace hapticd {

using WaveRestTouches = FixedVector<WaveRestTouch, kMaxWaveRests>;

/// The rests that the string may meet in the tick, those under tools first. These are led to where
/// the string lies on what is under them. 0.3 us with 200.
HD_REALTIME void find_rests(const Playing& playing, NearTools& tools, const Touches& touches,
                            WaveRestTouches& rests) noexcept;

}  // namespace hapticd
