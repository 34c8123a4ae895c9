// See work_cost.h.
#include "server/daemon/work_cost.h"

#include <algorithm>
#include <cmath>

#include "core/contact/tick_work.h"

namespace hapticd {
namespace {

/// Ticks that means look back over. Fewer: a mean follows noise.
constexpr int kMeanTicks = 1024;
/// Contact ticks before their mean price is more than a guess.
constexpr int kKnownTicks = 32;
/// Large ticks before their dearest are one in a thousand.
constexpr int kManyTicks = 256;

void follow(double value, double share, double& mean) noexcept { mean += share * (value - mean); }

void add(double value, DearTicks& ticks) noexcept {
  DearTicks::Block& block = ticks.block;
  if (block.ticks == kPriceBlock) {
    ticks.last = block;
    block = {};
  }
  block.least = block.ticks == 0 ? value : std::min(block.least, value);
  ++block.ticks;
  for (double& dear : block.dearest) {
    if (value > dear) std::swap(value, dear);
  }
}

/// 0 while too few were seen.
double dearest(const DearTicks& ticks) noexcept {
  return std::max(ticks.block.dearest.back(), ticks.last.dearest.back());
}

double least(const DearTicks& ticks) noexcept {
  return ticks.last.ticks > 0 ? std::min(ticks.block.least, ticks.last.least) : ticks.block.least;
}

bool is_idle(std::int64_t work, const WorkCost& price) noexcept {
  return work <= kIdleWork || static_cast<double>(work) <= 2.0 * least(price.work);
}

double unit_price(const WorkCost& price) noexcept {
  if (price.touching_ticks < kKnownTicks || price.touching_work <= 0.0) {
    return kGuessed * kNominalWork_ns;
  }
  const double mean = price.touching_ns / price.touching_work;
  const double dear = dearest(price.large);
  if (dear == 0.0) return kUnsure * mean;
  const int seen = price.large.block.ticks + price.large.last.ticks;
  return std::max(seen < kManyTicks ? kFew * dear : dear, mean);
}

/// What the machine adds to one idle tick in a thousand.
double added_ns(const WorkCost& price) noexcept {
  return std::max(dearest(price.idle) - price.idle_ns, 0.0);
}

void learn_idle(double cpu_ns, double work, WorkCost& price) noexcept {
  // Idle until now was a contact that lasted.
  if (2.0 * work < price.idle_work) {
    price.idle = {};
    price.idle_ticks = 0;
  }
  add(cpu_ns, price.idle);
  price.idle_ticks = std::min(price.idle_ticks + 1, kMeanTicks);
  const double usual_ns =
      price.idle_ticks > 1 ? std::min(cpu_ns, kForeignFactor * price.idle_ns) : cpu_ns;
  follow(usual_ns, 1.0 / price.idle_ticks, price.idle_ns);
  follow(work, 1.0 / price.idle_ticks, price.idle_work);
}

void learn_touching(double beyond_ns, double work, WorkCost& price) noexcept {
  const bool known = price.touching_ticks >= kKnownTicks;
  price.touching_ticks = std::min(price.touching_ticks + 1, kMeanTicks);
  const double usual_ns =
      known ? std::min(beyond_ns, kForeignFactor * unit_price(price) * work) : beyond_ns;
  follow(usual_ns, 1.0 / price.touching_ticks, price.touching_ns);
  follow(work, 1.0 / price.touching_ticks, price.touching_work);
}

void learn_large(double unit_ns, WorkCost& price) noexcept {
  // Of two foreign ticks in a row the cheaper counts.
  const bool foreign = unit_ns > kForeignFactor * unit_price(price);
  if (!foreign) {
    add(unit_ns, price.large);
  } else if (price.foreign > 0.0) {
    add(std::min(price.foreign, unit_ns), price.large);
  }
  price.foreign = foreign ? unit_ns : 0.0;
}

/// What fits into the time, within what a budget of work can say.
double fitting_work(double time_ns, double unit_ns) noexcept {
  return std::clamp(time_ns / unit_ns, 1.0, 1e15);
}

}  // namespace

void learn(const PricedTick& tick, WorkCost& price) noexcept {
  if (tick.cpu_ns <= 0) return;
  const auto cpu_ns = static_cast<double>(tick.cpu_ns);
  const auto work = static_cast<double>(tick.work);
  add(work, price.work);
  if (is_idle(tick.work, price)) {
    learn_idle(cpu_ns, work, price);
    return;
  }
  const double beyond = work - price.idle_work;
  if (beyond <= 0.0) return;
  learn_touching(std::max(cpu_ns - price.idle_ns, 0.0), beyond, price);
  if (tick.work < price.large_work) return;
  learn_large(std::max(cpu_ns - price.idle_ns - added_ns(price), 0.0) / beyond, price);
}

std::int64_t judged_cost(const PricedTick& tick, const WorkCost& price) noexcept {
  const double beyond = std::max(static_cast<double>(tick.work) - price.idle_work, 0.0);
  const double own_ns = price.idle_ns + beyond * unit_price(price);
  const double spared_ns = static_cast<double>(tick.cpu_ns) - added_ns(price);
  return std::min(tick.cpu_ns, static_cast<std::int64_t>(std::max(own_ns, spared_ns)));
}

std::int64_t affordable_work(double budget_ns, WorkCost& price) noexcept {
  const double added = added_ns(price);
  const double base_ns = price.idle_ns + (added <= kKeptBack * budget_ns ? added : 0.0);
  const double spent_ns = kSpentShare * budget_ns;
  const double unit_ns = unit_price(price);
  const double work = spent_ns > base_ns
                          ? price.idle_work + fitting_work(spent_ns - base_ns, unit_ns)
                          : price.idle_work * (spent_ns / base_ns);
  price.large_work = static_cast<std::int64_t>(0.5 * work);
  return std::max(static_cast<std::int64_t>(work), std::int64_t{1});
}

std::int64_t nominal_work(double budget_ns) noexcept {
  return static_cast<std::int64_t>(fitting_work(kNominalShare * budget_ns, kNominalWork_ns));
}

std::int64_t first_work(double budget_ns, bool virtual_time) noexcept {
  if (!(budget_ns > 0.0)) return 0;
  WorkCost unknown;
  return virtual_time ? nominal_work(budget_ns) : affordable_work(budget_ns, unknown);
}

bool worth_telling(std::int64_t work, std::int64_t told) noexcept {
  if (work == told) return false;
  return work == 0 || told == 0 || std::abs(work - told) > told / 64;
}

}  // namespace hapticd
