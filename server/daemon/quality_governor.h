// Chooses the level of automatic quality from what ticks cost: down at once when they go beyond the
// budget, up only after a calm time and one level at a time, and after the longer a wait the more
// often that level was too much. Ticks that the work budget cuts short stay within the budget and
// ask for no lower level, whose geometry costs more accuracy than linearisations, but for no higher
// one either. A pure function of measured numbers: no clock is read. Not RT.
#pragma once

#include <array>
#include <cstdint>

#include "core/scene/quality.h"

namespace hapticd {

/// Same numbers as hapticd::v1::QualityReason.
enum class QualityReason : std::uint8_t {
  kChosen = 1,    ///< asked for
  kRoom = 2,      ///< room in the budget: climbing, or at the top
  kBudget = 3,    ///< ticks came near the budget: descending, or another level would not fit
  kSettling = 4,  ///< waits before it changes again
};

/// Ticks are judged in windows of so long, ns: long enough for the rare expensive tick to count.
inline constexpr std::int64_t kGovernorWindow_ns = 250'000'000;
/// Share of a window's ticks that may be over the budget, 1 in so many. Larger: descends at less.
inline constexpr std::uint64_t kOverOneIn = 100;
/// Time after a change that is not judged, ns: its ramp, and caches that fill anew.
inline constexpr std::int64_t kSettling_ns = 300'000'000;
/// A level climbs only while 99 of 100 ticks stay below this share of the budget. Nearer to 1:
/// climbs that are taken back.
inline constexpr double kRoomShare = 0.6;
/// Calm windows in a row before a climb.
inline constexpr int kCalmWindows = 8;
/// Time for which a level that was too much is not tried again, ns; doubled each time it was.
inline constexpr std::int64_t kRetry_ns = 10'000'000'000;
inline constexpr std::int64_t kMaxRetry_ns = 320'000'000'000;

/// One tick.
struct TickCost {
  std::int64_t t_ns = 0;    ///< never decreasing
  std::int64_t cpu_ns = 0;  ///< CPU time that its work took; 0: not known, is left out
  int level = 0;            ///< it was computed with, [0, kQualityLevels)
  bool cut_short = false;   ///< a work budget ended it
};

/// Kept between ticks; begin anew with each scene.
struct QualityGovernor {
  QualityReason reason = QualityReason::kSettling;
  int level = -1;  ///< last asked for; -1: nothing seen yet
  std::int64_t settled_ns = 0;
  std::int64_t window_ns = 0;     ///< begin of the window
  std::uint64_t ticks = 0;        ///< of the window
  std::uint64_t over_budget = 0;  ///< ticks of the window
  std::uint64_t over_room = 0;    ///< ticks of the window
  int calm = 0;                   ///< windows
  struct Rung {
    std::int64_t retry_ns = 0;  ///< not before
    std::int64_t wait_ns = kRetry_ns;
  };
  std::array<Rung, kQualityLevels> rungs{};
};

/// The level to play at after `tick`; `budget_ns` > 0 per tick. Cost: some ns.
[[nodiscard]] int govern(const TickCost& tick, std::int64_t budget_ns,
                         QualityGovernor& governor) noexcept;

}  // namespace hapticd
