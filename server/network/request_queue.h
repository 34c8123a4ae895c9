// The order of requests: of each session one after the other, Stop before all others, and what
// costs much one at a time of all sessions. Carries out those that are the server's own and passes
// the others on to the host. PROTOCOL.md, section 8. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "server/network/lease.h"
#include "server/network/server_host.h"
#include "server/network/sessions.h"
#include "server/network/time_budget.h"

namespace hapticd {

class RequestQueue {
 public:
  /// `work_time` as in ServerOptions. All others must outlive this.
  RequestQueue(Sessions& sessions, Lease& lease, const ServerHost& host,
               std::function<std::int64_t()> work_time);

  /// An Item of a session that is open, applied in its turn.
  void take(Session& session, wire::ReceivedItem& received);
  /// The next request that costs much, if any waits.
  void serve_costly();
  /// The host's result of a request. Ignored when its session has ended or it has been answered
  /// already.
  void answer(const RequestId& id, v1::Result result);
  /// The session has ended: what waits is forgotten, and the host told of what it has.
  void abandon(Session& session);

 private:
  void overtake(Session& session, const wire::ReceivedItem& received);
  void pump(Session& session);
  [[nodiscard]] bool costs_too_much_now(const Session& session) const;
  [[nodiscard]] bool has_budget(const Session& session) const;
  void charge(Session& session, std::int64_t taken_ns);
  void carry_out(Session& session, const v1::Item& item);
  void subscribe(Session& session, const v1::Subscribe& request);
  void acquire(Session& session, const v1::Acquire& request);
  void end_run(Session& session);
  void finish(Session& session, v1::Result result);
  void tell_result(Session& session, std::uint64_t item, v1::Result result);

  Sessions& sessions_;
  Lease& lease_;
  const ServerHost& host_;
  std::function<std::int64_t()> work_time_;
  std::vector<std::pair<Address, TimeBudget>> address_budgets_;  ///< of those that owe something
  std::uint64_t served_last_ = 0;  ///< serial of the session whose turn it was last to cost much
};

}  // namespace hapticd
