// See quality.h. The errors are those of tests/benchmark/results/intel-xeon-processor.md.
#include "core/scene/quality.h"

#include <array>

#include "core/math/assert.h"

namespace hapticd {
namespace {

struct Rung {
  int sub_steps;
  double stop_tolerance;  ///< m
  double force_error;
};

constexpr std::array<Rung, kQualityLevels> kLadder{{
    {2, 1e-5, 0.064},
    {8, 1e-5, 0.036},
    {16, 1e-6, 0.0067},
    {24, 1e-6, 1.3e-5},
    {32, 1e-7, 1e-5},
}};

}  // namespace

Quality quality_of(int level) noexcept {
  HD_ASSERT(level >= 0 && level < kQualityLevels);
  const Rung& rung = kLadder[static_cast<std::size_t>(level)];
  Quality quality;
  quality.options.sub_steps = rung.sub_steps;
  quality.options.stop_tolerance = rung.stop_tolerance;
  quality.force_error = rung.force_error;
  return quality;
}

int quality_for(double force_error) noexcept {
  int level = 0;
  while (level + 1 < kQualityLevels && quality_of(level).force_error > force_error) ++level;
  return level;
}

}  // namespace hapticd
