// Sliding root mean square. See thermal_limit.h. RT: yes.
#include "core/safety/thermal_limit.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

void add_load(double size, double dt_s, const ThermalRating& rating, ThermalLoad& load) noexcept {
  const double block_s = rating.window_s / kThermalBlocks;
  load.current_s += dt_s;
  for (int passed = 0; load.current_s >= block_s && passed <= kThermalBlocks; ++passed) {
    load.blocks[static_cast<std::size_t>(load.oldest)] = load.current;
    load.oldest = (load.oldest + 1) % kThermalBlocks;
    load.current = 0.0;
    load.current_s -= block_s;
  }
  // After a pause of more than a window nothing older is left anyway.
  load.current_s = std::min(load.current_s, block_s);
  // A tick across the edge of two blocks counts in the later one: it is never forgotten too early.
  const double floor = kThermalFloor * rating.continuous * rating.continuous;
  load.current += std::max(0.0, size * size - floor) * dt_s;
}

double allowed_size(const ThermalRating& rating, const ThermalLoad& load) noexcept {
  double held = load.current;
  for (const double block : load.blocks) held += block;
  const double square = rating.continuous * rating.continuous;
  const double left = (1.0 - kThermalFloor) * square * rating.window_s - held;
  return std::sqrt(kThermalFloor * square + std::max(0.0, left) / kThermalHorizon_s);
}

}  // namespace hapticd
