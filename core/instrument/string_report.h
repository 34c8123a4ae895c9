// Writes the events of one string. Internal to the folder. RT: yes.
#pragma once

#include <cstdint>

#include "core/instrument/instrument_options.h"
#include "core/instrument/modal_string.h"
#include "core/instrument/release_detector.h"
#include "core/instrument/string_parameters.h"
#include "core/instrument/string_touch.h"
#include "core/instrument/vibration.h"
#include "core/tick/string_event.h"

namespace hapticd {

/// Where the events of one string go. What does not fit is counted there.
struct StringReport {
  const StringConstants& string;
  std::int32_t index;
  StringEvents& events;
};

/// kTouch at t_ns.
HD_REALTIME void report_touch(const StringReport& report, const StringTouch& touch, bool ringing,
                              std::int64_t t_ns) noexcept;

/// kPress at t_ns, with the deflection of this tick.
HD_REALTIME void report_armed(const StringReport& report, const StringTouch& touch,
                              double deflection, std::int64_t t_ns) noexcept;

/// kLeave or kRelease of the touch that the detector has just seen end.
HD_REALTIME void report_end(const StringReport& report, const ReleaseDetector& detector,
                            StringEventKind kind, std::int64_t t_ns) noexcept;

/// kTone of that release, of `amplitude` (m) where it was released; `modes` null where there are
/// none.
HD_REALTIME void report_tone(const StringReport& report, const InstrumentOptions& options,
                             const ReleaseDetector& detector, const Vibration& vibration,
                             double amplitude, const ModalString* modes) noexcept;

/// kRadius: the string is bent by `deflection` (m) from t_ns on.
HD_REALTIME void report_press_radius(const StringReport& report, double deflection,
                                     std::int64_t t_ns) noexcept;

/// kRadius: it rings with `amplitude` (m) at t_ns, decaying with `decay` (s); 0, 0: it is still.
HD_REALTIME void report_ringing_radius(const StringReport& report, RadiusPhase phase,
                                       double amplitude, double decay, std::int64_t t_ns) noexcept;

}  // namespace hapticd
