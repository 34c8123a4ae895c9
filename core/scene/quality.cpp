// See quality.h.
#include "core/scene/quality.h"

#include <array>

#include "core/math/assert.h"

namespace hapticd {
namespace {

struct Rung {
  int sub_steps;
  double stop_tolerance;  ///< m
  double force_error;
  double work;  ///< of the default's
};

constexpr std::array<Rung, kQualityLevels> kLadder{{
#include "core/scene/quality_levels.inc"
}};

}  // namespace

Quality quality_of(int level) noexcept {
  HD_ASSERT(level >= 0 && level < kQualityLevels);
  const Rung& rung = kLadder[static_cast<std::size_t>(level)];
  Quality quality;
  quality.options.sub_steps = rung.sub_steps;
  quality.options.stop_tolerance = rung.stop_tolerance;
  quality.force_error = rung.force_error;
  quality.work = rung.work;
  return quality;
}

int quality_for(double force_error) noexcept {
  int level = 0;
  while (level + 1 < kQualityLevels && quality_of(level).force_error > force_error) ++level;
  return level;
}

bool quality_offers(double force_error) noexcept {
  return quality_of(quality_for(force_error)).force_error <= force_error;
}

void set_level(int level, LiveSettings& live) noexcept {
  const ContactOptions before = quality_of(static_cast<int>(live.quality_level)).options;
  const ContactOptions after = quality_of(level).options;
  ContactOptions& options = live.contact;
  if (options.sub_steps == before.sub_steps) options.sub_steps = after.sub_steps;
  if (options.stop_tolerance == before.stop_tolerance) {
    options.stop_tolerance = after.stop_tolerance;
  }
  live.quality_level = static_cast<std::uint32_t>(level);
}

}  // namespace hapticd
