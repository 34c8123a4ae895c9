// What work costs on this machine: learnt from the CPU time of its own ticks, so that the work of a
// tick can be bounded before it begins. Two points of a line: ticks with about the least work that
// ticks have of late, such as those in the air, and the time of a unit of work (see
// core/contact/tick_work.h) beyond theirs, as dear as one tick in a thousand finds it. Not a
// mean: a budget is kept by the dear ticks. What the machine adds to ticks in the air it adds to
// all, and is no price of work. A pure function of measured numbers: no clock is read. Not RT.
#pragma once

#include <array>
#include <cstdint>

namespace hapticd {

/// A tick with no more work than this is idle, units, and so is one with no more than twice the
/// least of late.
inline constexpr std::int64_t kIdleWork = 1000;
/// Ticks are judged in blocks of so many. More: slower to see that they have become cheaper.
inline constexpr int kPriceBlock = 2048;
/// Rank of the price that counts among a block's: the third dearest, which 1 tick in 1000 of the
/// two blocks looked at exceeds. More: the budget is exceeded more often.
inline constexpr std::size_t kDearRank = 3;
/// Share of the budget that is spent: prices beyond all that was seen. Nearer to 1: less room.
inline constexpr double kSpentShare = 0.95;
/// Counts have no noise: under the virtual clock a little more than the budget is allowed, as much
/// as a tick keeps back of it for a linearisation dearer than the last. More: ticks exceed the
/// budget.
inline constexpr double kNominalShare = 1.02;
/// Share of the budget up to which what the machine adds to a tick in a thousand is kept back for
/// it. What is added beyond, no work left out would pay for.
inline constexpr double kKeptBack = 0.25;
/// Factor on the price while it is a guess, on the mean one before a large tick was seen, and on
/// the dearest of few. Smaller: the first large ticks may take longer than the budget.
inline constexpr double kGuessed = 4.0;
inline constexpr double kUnsure = 1.5;
inline constexpr double kFew = 1.15;
/// A tick so many times as dear as the dearest counts when another one follows: an interrupt, a
/// page that was not there and the like are no price of work.
inline constexpr double kForeignFactor = 2.0;

/// What a tick took.
struct PricedTick {
  std::int64_t cpu_ns = 0;  ///< 0: not known, is left out
  std::int64_t work = 0;
};

/// Numbers of a block of ticks and of the one before it, of which the dearest and the least count.
struct DearTicks {
  struct Block {
    std::array<double, kDearRank> dearest{};  ///< falling
    double least = 0.0;
    int ticks = 0;
  };
  Block block;  ///< being filled
  Block last;
};

/// Kept between ticks; begin anew with each scene.
struct WorkCost {
  DearTicks work;        ///< of all ticks, units
  double idle_ns = 0.0;  ///< means of idle ticks; 0: none seen
  double idle_work = 0.0;
  int idle_ticks = 0;
  DearTicks idle;            ///< what they took, ns
  double touching_ns = 0.0;  ///< means of the others, beyond the idle ones
  double touching_work = 0.0;
  int touching_ticks = 0;
  std::int64_t large_work = 0;  ///< from so much on a tick is large: half of what was affordable
  DearTicks large;              ///< prices of large ticks, ns a unit
  double foreign = 0.0;         ///< price of a tick that waits for another as dear; 0: none
};

/// Takes note of a tick. Cost: some ns.
void learn(const PricedTick& tick, WorkCost& price) noexcept;

/// What `tick` says of the level it was computed at, ns: its time less what the machine adds to one
/// tick in a thousand in the air, but no less than what its work costs at the price that was
/// learnt, nor more than its time. 0: not known.
[[nodiscard]] std::int64_t judged_cost(const PricedTick& tick, const WorkCost& price) noexcept;

/// Work that a tick of `budget_ns` > 0 can do, >= 1, at the price that was learnt.
[[nodiscard]] std::int64_t affordable_work(double budget_ns, WorkCost& price) noexcept;

/// The same of kNominalShare at kNominalWork_ns a unit, whatever the machine: under the virtual
/// clock.
[[nodiscard]] std::int64_t nominal_work(double budget_ns) noexcept;

/// Work of a tick of `budget_ns` >= 0 before any has been seen: nominal_work under the virtual
/// clock, else what is affordable at the guessed price. 0, no bound, for a budget of 0.
[[nodiscard]] std::int64_t first_work(double budget_ns, bool virtual_time) noexcept;

/// False when `work` is so near to what was told that telling it changes nothing.
[[nodiscard]] bool worth_telling(std::int64_t work, std::int64_t told) noexcept;

}  // namespace hapticd
