// What of a scene may change while it plays, as plain numbers, and the way from one setting to
// another: numbers go straight from old to new value, so that no force steps; choices switch at
// once. SI. RT: yes, about 10 ns per string.
#pragma once

#include "core/contact/contact_problem.h"
#include "core/instrument/instrument_options.h"
#include "core/instrument/string_parameters.h"
#include "core/math/pose.h"
#include "core/math/realtime.h"

namespace hapticd {

/// Time a change takes, s. Shorter: a force step that can be felt; longer: sluggish knobs.
inline constexpr double kSettingsRamp_s = 0.05;

/// Settings of a tool and of all strings; those of single strings are StringParameters.
struct LiveSettings {
  CouplingStiffness coupling;
  double coupling_damping = 0.0;  ///< N s/m
  double force_gain = 1.0;
  double scale = 1.0;  ///< of the workspace
  Pose X_WD;
  ContactOptions contact;
  InstrumentOptions instrument;
  std::uint32_t quality_level = 0;
  bool quality_automatic = false;  ///< the level follows a budget
};

/// The settings `share` in [0, 1] of the way from `from` to `to`; exactly `to` at 1.
[[nodiscard]] HD_REALTIME LiveSettings blend(const LiveSettings& from, const LiveSettings& to,
                                             double share) noexcept;

/// Likewise for a string; ends and radius are those of `to`.
[[nodiscard]] HD_REALTIME StringParameters blend(const StringParameters& from,
                                                 const StringParameters& to, double share) noexcept;

}  // namespace hapticd
