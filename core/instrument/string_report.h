// Writes the events of a sounding string. Internal to the folder. RT: yes.
#pragma once

#include <cstdint>

#include "core/instrument/string_response.h"

namespace hapticd {

/// Where the events of a string go. What does not fit is counted there.
struct StringReport {
  const SoundingString& sounding;
  StringEvents& events;
};

/// What rings: an amplitude (m) at an instant, decaying with `decay` (s) from there; 0, 0: nothing.
struct Envelope {
  double amplitude;
  double decay;
  std::int64_t t_ns;
};

/// kTouch at t_ns.
HD_REALTIME void report_touch(const StringReport& report, const StringTouch& touch, bool ringing,
                              std::int64_t t_ns) noexcept;

/// kPress at t_ns, with the deflection of this tick.
HD_REALTIME void report_armed(const StringReport& report, const StringTouch& touch,
                              double deflection, std::int64_t t_ns) noexcept;

/// kLeave or kRelease of the touch that the detector has just seen end.
HD_REALTIME void report_end(const StringReport& report, StringEventKind kind,
                            std::int64_t t_ns) noexcept;

/// kTone of that release, of `amplitude` (m) where it was released.
HD_REALTIME void report_tone(const StringReport& report, double amplitude) noexcept;

/// kRadius: the string is bent by `deflection` (m) from t_ns on.
HD_REALTIME void report_press_radius(const StringReport& report, double deflection,
                                     std::int64_t t_ns) noexcept;

/// kRadius: it rings, or is still, from envelope.t_ns on.
HD_REALTIME void report_ringing_radius(const StringReport& report, RadiusPhase phase,
                                       const Envelope& envelope) noexcept;

}  // namespace hapticd
