// The resonances of the body for a sample rate, and its response. The frequencies, widths and
// heights are ours: low, broad resonances of a long shallow box of two boards, as Penttinen et al.
// (2006) describe the body of a guqin, not measured on one. Not RT.
#pragma once

#include "clients/audio/dsp/body.h"

namespace hapticd::audio {

/// The body at a sample rate, Hz, [8000, 192000].
[[nodiscard]] BodyFilter design_body(double rate_hz);

/// What it multiplies the amplitude of a sine by; `omega` in radians per frame.
[[nodiscard]] double body_gain(const BodyFilter& body, double omega);

}  // namespace hapticd::audio
