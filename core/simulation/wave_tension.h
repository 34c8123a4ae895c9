// The tension of a string that sounds, as its tools bend it and its swinging stretches it. SI. RT:
// yes, 50 ns; 3 us where it has changed, for its modes.
#pragma once

#include "core/simulation/wave_meeting.h"

namespace hapticd {

/// Several tools press the string, or the one that does has been rendered when another did: its law
/// is that of a part.
[[nodiscard]] HD_REALTIME bool is_parted(const Playing& playing, const Touches& touches) noexcept;

/// How much longer the tools bend the string, m.
[[nodiscard]] HD_REALTIME double extension_of(const Playing& playing) noexcept;

/// Of the string as the static laws of the tools bend it, N.
[[nodiscard]] HD_REALTIME double tension_of(const Playing& playing, const NearTools& tools,
                                            const Touches& touches) noexcept;

/// Tunes it for the tension `held` (N) by its tools, and what its swinging adds.
HD_REALTIME void tune(const Playing& playing, double held) noexcept;

}  // namespace hapticd
