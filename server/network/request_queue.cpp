// See request_queue.h.
#include "server/network/request_queue.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "proto/wire/request_result.h"
#include "proto/wire/request_rule.h"
#include "server/network/counted_causes.h"

namespace hapticd {
namespace {

using wire::result_of;

constexpr std::uint32_t kMaxDivisor = 1'000'000;
constexpr std::uint32_t kMaxContacts = 256;
constexpr std::uint32_t kUsualContacts = 16;
constexpr int kMaxSections = 32;

/// Of the network thread's time for requests that cost much, one part in so many is a session's,
/// and an address's. The holder of the lease has what it needs.
constexpr std::int64_t kSessionPart = 10;
constexpr std::int64_t kAddressPart = 4;

std::int64_t monotonic_ns() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

/// Looks at files for a session that may need no lease for it, so that many can ask: of each one in
/// kDearPeriod_ns. What is built for the holder of the lease is built by another thread.
bool is_dear(const v1::Item& item) {
  const v1::RequestRule* rule = wire::rule_of(item);
  return rule != nullptr && rule->cost() == v1::REQUEST_COST_BUILD && !wire::needs_lease(item);
}

/// Keeps this thread from hearing a Stop: one at a time between two looks at the socket.
bool is_costly(const v1::Item& item) {
  const v1::RequestRule* rule = wire::rule_of(item);
  return is_dear(item) || (rule != nullptr && rule->cost() == v1::REQUEST_COST_SCENE);
}

/// Ticks are advanced until it is answered.
bool is_run_of_steps(const v1::Item& item) {
  return item.has_run() && item.run().mode() == v1::RUN_MODE_STEP;
}

bool is_run_stop(const v1::Item& item) {
  return item.has_run() && item.run().mode() == v1::RUN_MODE_STOP;
}

}  // namespace

RequestQueue::RequestQueue(Sessions& sessions, Lease& lease, const ServerHost& host,
                           std::function<std::int64_t()> work_time)
    : sessions_(sessions),
      lease_(lease),
      host_(host),
      work_time_(work_time ? std::move(work_time) : monotonic_ns) {}

void RequestQueue::take(Session& session, wire::ReceivedItem& received) {
  const v1::Item& item = received.item;
  session.asked_control = session.asked_control || wire::needs_control(item);
  if (item.has_bye()) {
    sessions_.end(session, Phase::kLeft);
  } else if (received.undecodable) {
    tell_result(session, received.id,
                result_of(v1::RESULT_CODE_INVALID, {}, "the Chunks hold no Item"));
  } else if (wire::rule_of(item) == nullptr) {
    tell_result(
        session, received.id,
        result_of(v1::RESULT_CODE_UNSUPPORTED, {}, "this server does not know the request"));
  } else if (item.has_stop() || (is_run_stop(item) && session.runs_steps())) {
    overtake(session, received);
  } else if (session.waiting.size() >= kMaxWaitingRequests ||
             session.waiting_bytes + received.bytes > kMaxWaitingBytes) {
    ++sessions_.counters().requests_limited;
    tell_result(session, received.id,
                result_of(v1::RESULT_CODE_BUSY, {},
                          "too many requests are pending: wait for Results first"));
  } else {
    session.waiting_bytes += received.bytes;
    session.waiting.push_back({received.id, received.bytes, std::move(received.item)});
    pump(session);
  }
}

void RequestQueue::overtake(Session& session, const wire::ReceivedItem& received) {
  if (std::optional<v1::Result> refused = lease_.refusal(session, received.item)) {
    tell_result(session, received.id, std::move(*refused));
    return;
  }
  if (session.overtaking.size() + session.held_results.size() >= kMaxOvertaking) {
    ++sessions_.counters().requests_limited;
    tell_result(session, received.id,
                result_of(v1::RESULT_CODE_BUSY, {}, "stops are under way already"));
    return;
  }
  session.overtaking.push_back(received.id);
  host_.request({session.serial, received.id}, received.item);
}

void RequestQueue::pump(Session& session) {
  // A host that answers at once would call itself once per waiting request otherwise.
  if (session.pumping) return;
  session.pumping = true;
  while (session.phase == Phase::kOpen && !session.current.has_value() &&
         !session.waiting.empty() && !costs_too_much_now(session)) {
    const WaitingRequest request = std::move(session.waiting.front());
    session.waiting.pop_front();
    if (is_costly(request.body)) session.may_cost = false;
    session.waiting_bytes -= request.bytes;
    session.current =
        CurrentRequest{request.item, request.body.has_pose_batch(), is_run_of_steps(request.body)};
    carry_out(session, request.body);
  }
  session.pumping = false;
}

// What is refused costs nothing: it is not held up.
bool RequestQueue::costs_too_much_now(const Session& session) const {
  const v1::Item& next = session.waiting.front().body;
  return is_costly(next) && !session.may_cost && !lease_.refusal(session, next).has_value();
}

bool RequestQueue::has_budget(const Session& session) const {
  if (lease_.held_by(session)) return true;
  const std::int64_t now_ns = sessions_.now_ns();
  const auto owes_too_much = [&](const auto& address) {
    return same_network(address.first, session.address) && !address.second.has_left(now_ns);
  };
  return session.budget.has_left(now_ns) &&
         std::none_of(address_budgets_.begin(), address_budgets_.end(), owes_too_much);
}

void RequestQueue::charge(Session& session, std::int64_t taken_ns) {
  const std::int64_t now_ns = sessions_.now_ns();
  session.budget.charge(taken_ns, kSessionPart, now_ns);
  std::erase_if(address_budgets_, [&](const auto& each) { return each.second.is_whole(now_ns); });
  auto found =
      std::find_if(address_budgets_.begin(), address_budgets_.end(),
                   [&](const auto& each) { return same_network(each.first, session.address); });
  if (found == address_budgets_.end()) {
    found = address_budgets_.emplace(address_budgets_.end(), session.address, TimeBudget());
  }
  found->second.charge(taken_ns, kAddressPart, now_ns);
}

// One request that costs much, of one session, each time: what came before it, a Stop above all,
// has been heard by now, and what comes while it is carried out waits for no other. The sessions
// take turns.
void RequestQueue::serve_costly() {
  const auto ready = [this](const Session& session) {
    if (session.phase != Phase::kOpen || session.current.has_value() || session.waiting.empty() ||
        !has_budget(session)) {
      return false;
    }
    return !is_dear(session.waiting.front().body) || session.dear_due_ns <= sessions_.now_ns();
  };
  Session* next = nullptr;
  for (const auto& session : sessions_.all()) {  // In the order of their serial numbers.
    if (!ready(*session)) continue;
    if (next == nullptr) next = session.get();
    if (session->serial <= served_last_) continue;
    next = session.get();
    break;
  }
  if (next == nullptr) return;
  served_last_ = next->serial;
  if (is_dear(next->waiting.front().body)) {
    next->dear_due_ns = sessions_.now_ns() + kDearPeriod_ns;
  }
  const bool free_of_charge = lease_.held_by(*next);
  const std::int64_t began_ns = work_time_();
  next->may_cost = true;
  sessions_.serve(*next, [&] { pump(*next); });
  next->may_cost = false;
  if (!free_of_charge) charge(*next, work_time_() - began_ns);
}

void RequestQueue::carry_out(Session& session, const v1::Item& item) {
  if (std::optional<v1::Result> refused = lease_.refusal(session, item)) {
    finish(session, std::move(*refused));
    return;
  }
  switch (item.body_case()) {
    case v1::Item::kSubscribe:
      subscribe(session, item.subscribe());
      break;
    case v1::Item::kPing:
      finish(session, result_of(v1::RESULT_CODE_OK));
      break;
    case v1::Item::kGetCounts: {
      v1::Result result = result_of(v1::RESULT_CODE_OK);
      *result.mutable_counts() = counts_of(sessions_.counters());
      finish(session, std::move(result));
      break;
    }
    case v1::Item::kAcquire:
      acquire(session, item.acquire());
      break;
    case v1::Item::kRelease:
      finish(session, result_of(v1::RESULT_CODE_OK));
      lease_.give_up(session, LeaseEnd::kReleased);
      break;
    default:
      session.current->at_host = true;
      host_.request({session.serial, session.current->item}, item);
      break;
  }
}

void RequestQueue::finish(Session& session, v1::Result result) {
  const CurrentRequest request = *session.current;
  session.current.reset();
  if (request.is_run_of_steps) lease_.renew(session);
  if (!request.is_pose_batch || result.code() != v1::RESULT_CODE_OK) {
    tell_result(session, request.item, std::move(result));
  }
  for (auto& [item, held] : std::exchange(session.held_results, {})) {
    tell_result(session, item, std::move(held));
  }
}

void RequestQueue::tell_result(Session& session, std::uint64_t item, v1::Result result) {
  result.set_item_id(item);
  v1::Item answer_item;
  *answer_item.mutable_result() = std::move(result);
  sessions_.tell(session, answer_item);
}

void RequestQueue::answer(const RequestId& id, v1::Result result) {
  Session* session = sessions_.find(id.session);
  if (session == nullptr || session->phase != Phase::kOpen) return;
  if (session->current.has_value() && session->current->at_host &&
      session->current->item == id.item) {
    sessions_.serve(*session, [&] {
      finish(*session, std::move(result));
      pump(*session);
    });
    return;
  }
  const auto overtaking =
      std::find(session->overtaking.begin(), session->overtaking.end(), id.item);
  if (overtaking == session->overtaking.end()) return;
  session->overtaking.erase(overtaking);
  sessions_.serve(*session, [&] {
    if (session->runs_steps()) {
      session->held_results.emplace_back(id.item, std::move(result));
    } else {
      tell_result(*session, id.item, std::move(result));
    }
  });
}

void RequestQueue::subscribe(Session& session, const v1::Subscribe& request) {
  if (request.divisor() > kMaxDivisor) {
    finish(session,
           result_of(v1::RESULT_CODE_OUT_OF_RANGE, "subscribe.divisor", "at most 1000000"));
    return;
  }
  if (request.sections_size() > kMaxSections) {
    finish(session, result_of(v1::RESULT_CODE_OUT_OF_RANGE, "subscribe.sections", "at most 32"));
    return;
  }
  if (request.max_contacts() > kMaxContacts) {
    finish(session,
           result_of(v1::RESULT_CODE_OUT_OF_RANGE, "subscribe.max_contacts", "at most 256"));
    return;
  }
  Subscription subscription;
  subscription.divisor = request.divisor();
  subscription.max_contacts = request.has_max_contacts() ? request.max_contacts() : kUsualContacts;
  const auto want = [&](int section) {
    if (section > 0 && section < 32 && v1::Section_IsValid(section)) {
      subscription.sections |= 1U << static_cast<unsigned>(section);
    }
  };
  for (const int section : request.sections()) want(section);
  if (request.sections_size() == 0) {
    want(v1::SECTION_TOOLS);
    want(v1::SECTION_STRINGS);
    want(v1::SECTION_CONTACTS);
  }
  session.flow.subscribe(subscription);
  session.newest_state.reset();
  finish(session, result_of(v1::RESULT_CODE_OK));
}

void RequestQueue::acquire(Session& session, const v1::Acquire& request) {
  Lease::Granted granted = lease_.acquire(session, request);
  if (Session* before = sessions_.find(granted.lost_by)) end_run(*before);
  finish(session, std::move(granted.result));
  if (granted.changed) lease_.tell();
}

// The time of whoever took the lease over is not run by another's request. Answered first: the
// host's own answer to a Run that it ends is not wanted any more.
void RequestQueue::end_run(Session& session) {
  if (!session.runs_steps()) return;
  const RequestId run{session.serial, session.current->item};
  sessions_.serve(session, [&] { finish(session, lease_.not_owner(session)); });
  host_.abandoned(run);
  sessions_.serve(session, [&] { pump(session); });
}

void RequestQueue::abandon(Session& session) {
  session.waiting.clear();
  session.waiting_bytes = 0;
  const auto current = std::exchange(session.current, std::nullopt);
  session.held_results.clear();
  for (const std::uint64_t item : std::exchange(session.overtaking, {})) {
    host_.abandoned({session.serial, item});
  }
  if (current.has_value() && current->at_host) host_.abandoned({session.serial, current->item});
}

}  // namespace hapticd
