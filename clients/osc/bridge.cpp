// See bridge.h.
#include "clients/osc/bridge.h"

#include <time.h>

#include "clients/library/client.h"

namespace hapticd::osc {

void Bridge::item(const v1::Item& item, const Clocks& clocks) {
  if (const auto message = message_of(item)) send(*message, clocks);
}

void Bridge::state(const v1::State& state, const Clocks& clocks) {
  for (const OscMessage& message : poses_of(state)) send(message, clocks);
}

void Bridge::send(const OscMessage& message, const Clocks& clocks) {
  const Schedule when = schedule(message.t_ns, delay_ns_, clocks);
  if (!send_(message, when.tag)) {
    ++counters_.unsent;
    return;
  }
  ++counters_.sent;
  if (when.late) ++counters_.late;
}

Clocks clocks_now(const wire::ClockEstimate& estimate, bool virtual_clock) {
  Clocks clocks;
  timespec day{};
  clock_gettime(CLOCK_REALTIME, &day);
  clocks.monotonic_ns = client::monotonic_now_ns();
  clocks.unix_ns = std::int64_t{day.tv_sec} * 1'000'000'000 + day.tv_nsec;
  if (estimate.known() && !virtual_clock) {
    clocks.daemon_minus_ns = estimate.at(clocks.monotonic_ns).offset_ns;
  }
  return clocks;
}

}  // namespace hapticd::osc
