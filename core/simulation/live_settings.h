// What of a scene may change while it plays, as plain numbers, and the way from one setting to
// another, so that no force steps. What force follows in proportion of its logarithm, as that of a
// spring among others does, goes by equal factors, as many as it takes; what force follows evenly
// goes straight; choices switch at once. SI. RT: yes, about 10 ns per string, and 80 ns for each
// scale that changes.
#pragma once

#include <array>
#include <cstddef>

#include "core/contact/contact_problem.h"
#include "core/instrument/instrument_options.h"
#include "core/instrument/string_parameters.h"
#include "core/math/pose.h"
#include "core/math/realtime.h"

namespace hapticd {

/// Time a change takes, s, at least. Shorter: a force step that can be felt; longer: sluggish
/// knobs.
inline constexpr double kSettingsRamp_s = 0.05;

/// Largest rate at which a force that is proportional to a scale follows it, 1/s, as a logarithm.
/// In a network of springs of which one changes from a to b no force moves in 1 ms by more than
/// (1 - exp(-r)) / (1 - exp(-r N)) of its way, r being this in 1 ms and N the ms it takes: each is
/// a sum of terms k / (k + c). 55 keeps that below 3/50 for N >= 50; larger: a step that is felt.
inline constexpr double kScalePace = 55.0;

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

/// The settings `share` in [0, 1] of the way from `from` to `to`; exactly `to` at 1. Each number
/// stays between its two ends.
[[nodiscard]] HD_REALTIME LiveSettings blend(const LiveSettings& from, const LiveSettings& to,
                                             double share) noexcept;

/// A number that goes by equal factors: what decides its course, and how far it has come.
struct ScaleWay {
  double floor = 0.0;
  double from = 0.0;
  double to = 0.0;
  double now = 0.0;
};

/// Likewise for strings, many of which go the same way; ends and radius are those of `to`.
/// `stiffest`: the largest kt on the way, N/m, above which a contact stiffness has no effect and
/// takes no part of the way.
class StringBlend {
 public:
  StringBlend(double share, double stiffest) noexcept : share_(share), stiffest_(stiffest) {}
  [[nodiscard]] HD_REALTIME StringParameters operator()(const StringParameters& from,
                                                        const StringParameters& to) noexcept;

 private:
  double share_;
  double stiffest_;
  std::array<ScaleWay, 9> last_;  ///< of the string before, number by number
};

/// How far scales go, as logarithms times the power that force follows each with.
struct WayLength {
  double most = 0.0;
  /// Of those whose law has an edge: on one side of it force does not change at all, as friction
  /// does not while a string sticks, so that all of its change may fall into a small part of the
  /// way.
  double edged = 0.0;
};

[[nodiscard]] HD_REALTIME WayLength way_length(const LiveSettings& from,
                                               const LiveSettings& to) noexcept;
[[nodiscard]] HD_REALTIME WayLength way_length(const StringParameters& from,
                                               const StringParameters& to,
                                               double stiffest) noexcept;

/// Time the way takes, s, >= kSettingsRamp_s: so that no scale goes faster than kScalePace.
[[nodiscard]] HD_REALTIME double ramp_time(const WayLength& length) noexcept;

/// from^(1 - share) to^share of two positive numbers; exactly `to` at 1.
[[nodiscard]] HD_REALTIME double blend_scale(double from, double to, double share) noexcept;

}  // namespace hapticd
