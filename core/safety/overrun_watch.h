// Counts late ticks: more than 20 within a second is no longer realtime. RT: yes, about 2 ns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/math/realtime.h"

namespace hapticd {

/// Late ticks within kLateWindow_ns that are still put up with. More: a force that is late for
/// longer; fewer: a fault from one burst of interrupts.
inline constexpr int kLateTicksAllowed = 20;
/// Window of that budget, ns.
inline constexpr std::int64_t kLateWindow_ns = 1'000'000'000;

/// Instants of the last late ticks.
struct OverrunWatch {
  std::array<std::int64_t, kLateTicksAllowed + 1> late_ns{};
  std::uint64_t total = 0;  ///< late ticks ever
};

/// Notes a late tick at `now_ns`; call with late = false in every other tick. True while more than
/// kLateTicksAllowed of them lie within the second before `now_ns` (times never go back). Whether
/// that is a fault depends on the device: latches().
[[nodiscard]] HD_REALTIME bool watch_overrun(bool late, std::int64_t now_ns,
                                             OverrunWatch& watch) noexcept;

}  // namespace hapticd
