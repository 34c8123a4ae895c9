// Budget of late ticks. See overrun_watch.h. RT: yes.
#include "core/safety/overrun_watch.h"

namespace hapticd {

bool watch_overrun(bool late, std::int64_t now_ns, OverrunWatch& watch) noexcept {
  constexpr std::uint64_t kPlaces = kLateTicksAllowed + 1;
  if (late) watch.late_ns[watch.total++ % kPlaces] = now_ns;
  if (watch.total < kPlaces) return false;
  // The next place to be overwritten holds the oldest of the last 21.
  return now_ns - watch.late_ns[watch.total % kPlaces] < kLateWindow_ns;
}

}  // namespace hapticd
