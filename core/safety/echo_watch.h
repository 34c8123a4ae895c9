// The delay from sample to force of a device that echoes which command it obeys: the instant at
// which a command took effect less that of the sample it was computed from, both by the device's
// clock. Kept by the driver, which gives the estimate with each sample; the stiffness clamp then
// reckons with it instead of the declared delay. RT: yes, O(1).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/math/realtime.h"
#include "core/safety/stiffness_clamp.h"

namespace hapticd {

/// Samples whose instants are remembered: delays of up to this many samples are measured. Normal
/// value half a second at 1 kHz; a device with a longer delay bears no stiffness worth the name.
inline constexpr std::size_t kEchoMemory = 512;

/// Start again at attach.
struct EchoWatch {
  struct Instant {
    std::uint64_t counter = 0;  ///< of the sample; 0: none
    std::int64_t t_ns = 0;
  };
  std::array<Instant, kEchoMemory> samples{};  ///< by counter, modulo
  std::uint64_t echoed = 0;                    ///< newest that was judged
  DelayEstimator estimator;
};

/// Remembers the instant of a sample, whose counter is > 0.
HD_REALTIME void note_sample(std::uint64_t counter, std::int64_t t_ns, EchoWatch& watch) noexcept;

/// Takes in that the command computed from sample `counter` took effect at `t_ns`. Only the first
/// echo of a command counts, and one of a sample that is no longer remembered says nothing. True
/// when the estimate changed.
HD_REALTIME bool note_echo(std::uint64_t counter, std::int64_t t_ns, EchoWatch& watch) noexcept;

}  // namespace hapticd
