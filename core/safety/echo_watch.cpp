// See echo_watch.h. RT: yes.
#include "core/safety/echo_watch.h"

namespace hapticd {

void note_sample(std::uint64_t counter, std::int64_t t_ns, EchoWatch& watch) noexcept {
  watch.samples[counter % kEchoMemory] = {counter, t_ns};
}

bool note_echo(std::uint64_t counter, std::int64_t t_ns, EchoWatch& watch) noexcept {
  if (counter <= watch.echoed) return false;
  watch.echoed = counter;
  const EchoWatch::Instant& sample = watch.samples[counter % kEchoMemory];
  if (sample.counter != counter) return false;
  return add_delay(t_ns - sample.t_ns, watch.estimator);
}

}  // namespace hapticd
