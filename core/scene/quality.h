// The ladder of quality: five settings of the contact problem, chosen and measured by hapticd-lab
// tradeoff, which writes quality_levels.inc: each is on the front, where less error costs more.
// Offline; plain data.
#pragma once

#include "core/contact/contact_problem.h"
#include "core/simulation/live_settings.h"

namespace hapticd {

/// Levels, 0 the fastest.
inline constexpr int kQualityLevels = 5;
inline constexpr int kDefaultQuality = 3;

struct Quality {
  ContactOptions options;
  /// Bound of the error of the force, rms over rms, against 400 linearisations per tick: in the
  /// worst of the study's scenes, over many gestures; other ones stay within 1.2 times.
  double force_error = 0.0;
  /// Work of a tick in touch (core/contact/tick_work.h) as a share of the default level's.
  double work = 1.0;
};

/// Setting of `level` in [0, kQualityLevels).
[[nodiscard]] Quality quality_of(int level) noexcept;

/// The cheapest level whose force error is at most `force_error` (> 0); the most exact where none
/// is.
[[nodiscard]] int quality_for(double force_error) noexcept;

/// True where some level's force error is at most `force_error`.
[[nodiscard]] bool quality_offers(double force_error) noexcept;

/// Takes `live` to `level` in [0, kQualityLevels): what its present level had decided of the
/// contact problem is decided again; what the scene itself gave is kept.
void set_level(int level, LiveSettings& live) noexcept;

}  // namespace hapticd
