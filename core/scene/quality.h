// The ladder of quality: five settings of the optimiser, each with the error it was measured to
// have. Offline; plain data.
#pragma once

#include "core/rendering/configuration_optimiser.h"
#include "core/simulation/live_settings.h"

namespace hapticd {

/// Levels, 0 the fastest.
inline constexpr int kQualityLevels = 5;
inline constexpr int kDefaultQuality = 3;

struct Quality {
  OptimiserOptions options;
  /// Error of the force, rms over rms, in the worst of the five sessions of tests/benchmark against
  /// 400 linearisations per tick.
  double force_error = 0.0;
};

/// Setting of `level` in [0, kQualityLevels).
[[nodiscard]] Quality quality_of(int level) noexcept;

/// The cheapest level whose force error is at most `force_error` (> 0); the most exact where none
/// is.
[[nodiscard]] int quality_for(double force_error) noexcept;

/// Takes `live` to `level` in [0, kQualityLevels): what its present level had decided of the
/// optimiser is decided anew, what the scene gave itself stands.
void set_level(int level, LiveSettings& live) noexcept;

}  // namespace hapticd
