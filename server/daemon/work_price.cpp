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
  if (++block.ticks > kPriceBlock) {
    price.last = block;
    block = {};
    block.ticks = 1;
  }
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
  if (unit_ns > kForeign * unit_price(price)) {
    const double before = price.foreign;
    price.foreign = unit_ns;
    if (before == 0.0) return;
    add(std::min(before, unit_ns), price);
    return;
  }
  price.foreign = 0.0;
  add(unit_ns, price);
}

std::int64_t affordable_work(WorkPrice& price, double budget_ns, bool nominal) noexcept {
  const double unit_ns = nominal ? kNominalWork_ns : unit_price(price);
  const double left_ns = nominal ? budget_ns : kSpentShare * budget_ns - price.idle_ns;
  const double work = std::clamp(left_ns / unit_ns, 1.0, 1e15);
  price.large_work = static_cast<std::int64_t>(0.5 * work);
  return static_cast<std::int64_t>(work);
}

bool worth_telling(std::int64_t work, std::int64_t told) noexcept {
  if (work == told) return false;
  return work == 0 || told == 0 || std::abs(work - told) > told / 64;
}

}  // namespace hapticd
