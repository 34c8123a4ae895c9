// See work_price.h.
#include "server/daemon/work_price.h"

#include <algorithm>
#include <cmath>

#include "core/rendering/tick_work.h"

namespace hapticd {
namespace {

/// Ticks that means look back over. Fewer: a mean follows noise.
constexpr int kMeanTicks = 1024;
/// Contact ticks before their mean price is more than a guess.
constexpr int kKnownTicks = 32;
/// Large ticks before their dearest are one in a thousand.
constexpr int kManyTicks = 256;

void follow(double value, double share, double& mean) noexcept { mean += share * (value - mean); }

void add(double unit_ns, WorkPrice& price) noexcept {
  WorkPrice::Block& block = price.block;
  if (block.ticks == kPriceBlock) {
    price.last = block;
    block = {};
  }
  ++block.ticks;
  double value = unit_ns;
  for (double& dear : block.dearest) {
    if (value > dear) std::swap(value, dear);
  }
}

/// 0 while too few large ticks were seen.
double dearest(const WorkPrice& price) noexcept {
  return std::max(price.block.dearest.back(), price.last.dearest.back());
}

double unit_price(const WorkPrice& price) noexcept {
  const double mean = price.touching_ticks >= kKnownTicks && price.touching_work > 0.0
                          ? kUnsure * price.touching_ns / price.touching_work
                          : kGuessed * kNominalWork_ns;
  const double dear = dearest(price);
  if (dear == 0.0) return mean;
  return price.block.ticks + price.last.ticks < kManyTicks ? kFew * dear : dear;
}

/// What fits into the time, within what a budget of work can say.
double fitting_work(double time_ns, double unit_ns) noexcept {
  return std::clamp(time_ns / unit_ns, 1.0, 1e15);
}

}  // namespace

void learn(const PricedTick& tick, WorkPrice& price) noexcept {
  if (tick.cpu_ns <= 0) return;
  const auto cpu_ns = static_cast<double>(tick.cpu_ns);
  if (tick.work <= kIdleWork) {
    const bool cheaper = price.idle_ns == 0.0 || cpu_ns < price.idle_ns;
    follow(cpu_ns, cheaper ? 1.0 : 1.0 / kMeanTicks, price.idle_ns);
    return;
  }
  const double beyond_ns = std::max(cpu_ns - price.idle_ns, 0.0);
  const auto work = static_cast<double>(tick.work);
  price.touching_ticks = std::min(price.touching_ticks + 1, kMeanTicks);
  follow(beyond_ns, 1.0 / price.touching_ticks, price.touching_ns);
  follow(work, 1.0 / price.touching_ticks, price.touching_work);
  if (tick.work < price.large_work) return;
  const double unit_ns = beyond_ns / work;
  // Of two foreign ticks in a row the cheaper counts.
  const bool foreign = unit_ns > kForeign * unit_price(price);
  if (!foreign) {
    add(unit_ns, price);
  } else if (price.foreign > 0.0) {
    add(std::min(price.foreign, unit_ns), price);
  }
  price.foreign = foreign ? unit_ns : 0.0;
}

std::int64_t affordable_work(double budget_ns, WorkPrice& price) noexcept {
  const double work = fitting_work(kSpentShare * budget_ns - price.idle_ns, unit_price(price));
  price.large_work = static_cast<std::int64_t>(0.5 * work);
  return static_cast<std::int64_t>(work);
}

std::int64_t nominal_work(double budget_ns) noexcept {
  return static_cast<std::int64_t>(fitting_work(kNominalShare * budget_ns, kNominalWork_ns));
}

bool worth_telling(std::int64_t work, std::int64_t told) noexcept {
  if (work == told) return false;
  return work == 0 || told == 0 || std::abs(work - told) > told / 64;
}

}  // namespace hapticd
