// See counted_causes.h.
#include "server/network/counted_causes.h"

#include <array>

namespace hapticd {
namespace {

template <auto Member>
std::uint64_t of_server(const ServerCounters& counters) {
  return counters.*Member;
}

template <auto Member>
std::uint64_t of_hellos(const ServerCounters& counters) {
  return counters.hellos.*Member;
}

template <auto Member>
std::uint64_t of_stop(const ServerCounters& counters) {
  return (counters.stop.*Member).value();
}

using Server = ServerCounters;
using Hellos = HelloCounters;
using StopRoad = StopCounters;

constexpr std::array kCauses{
    CountedCause{"received", false, of_server<&Server::received>},
    CountedCause{"sent", false, of_server<&Server::sent>},
    CountedCause{"overflowed", true, of_server<&Server::overflowed>},
    CountedCause{"unsent", true, of_server<&Server::unsent>},
    CountedCause{"bad_header", true, of_server<&Server::bad_header>},
    CountedCause{"unknown_session", true, of_server<&Server::unknown_session>},
    CountedCause{"repeated", true, of_server<&Server::repeated>},
    CountedCause{"forged", true, of_server<&Server::forged>},
    CountedCause{"unreadable", true, of_server<&Server::unreadable>},
    CountedCause{"hello_retried", false, of_hellos<&Hellos::retried>},
    CountedCause{"hello_welcomed", false, of_hellos<&Hellos::welcomed>},
    CountedCause{"hello_repeated", false, of_hellos<&Hellos::repeated>},
    CountedCause{"hello_malformed", true, of_hellos<&Hellos::malformed>},
    CountedCause{"hello_forged", true, of_hellos<&Hellos::forged>},
    CountedCause{"hello_limited", true, of_hellos<&Hellos::limited>},
    CountedCause{"hello_full", true, of_hellos<&Hellos::full>},
    CountedCause{"session_full", true, of_server<&Server::full>},
    CountedCause{"session_evicted", true, of_server<&Server::evicted>},
    CountedCause{"session_old_key", true, of_server<&Server::old_keys>},
    CountedCause{"session_revoked", true, of_server<&Server::revoked>},
    CountedCause{"session_protocol_error", true, of_server<&Server::protocol_errors>},
    CountedCause{"session_backlog", true, of_server<&Server::backlogs>},
    CountedCause{"session_silence", true, of_server<&Server::silences>},
    CountedCause{"session_fallen", true, of_server<&Server::fallen>},
    CountedCause{"request_limited", true, of_server<&Server::requests_limited>},
    CountedCause{"reset_sent", false, of_server<&Server::resets>},
    CountedCause{"reset_limited", true, of_server<&Server::resets_limited>},
    CountedCause{"item_untold", true, of_server<&Server::untold>},
    CountedCause{"state_unfit", true, of_server<&Server::unfit_states>},
    CountedCause{"stop_received", false, of_stop<&StopRoad::received>},
    CountedCause{"stop_obeyed", false, of_stop<&StopRoad::stops>},
    CountedCause{"stop_heartbeat", false, of_stop<&StopRoad::heartbeats>},
    CountedCause{"stop_challenged", false, of_stop<&StopRoad::challenged>},
    CountedCause{"stop_malformed", true, of_stop<&StopRoad::malformed>},
    CountedCause{"stop_forged", true, of_stop<&StopRoad::unauthenticated>},
    CountedCause{"stop_repeated", true, of_stop<&StopRoad::replayed>},
    CountedCause{"stop_other_daemon", true, of_stop<&StopRoad::other_daemon>},
    CountedCause{"stop_full", true, of_stop<&StopRoad::full>},
    CountedCause{"stop_unanswered", true, of_stop<&StopRoad::unanswered>},
};

}  // namespace

std::span<const CountedCause> counted_causes() { return kCauses; }

v1::Counts counts_of(const ServerCounters& counters) {
  v1::Counts counts;
  for (const CountedCause& cause : kCauses) {
    v1::Count& count = *counts.add_counts();
    count.set_cause(cause.name);
    count.set_count(cause.count(counters));
  }
  return counts;
}

}  // namespace hapticd
