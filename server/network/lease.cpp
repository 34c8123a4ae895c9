// See lease.h.
#include "server/network/lease.h"

#include "proto/wire/request_result.h"
#include "proto/wire/request_rule.h"
#include "proto/wire/shown_text.h"

namespace hapticd {
namespace {

using wire::result_of;

constexpr std::size_t kMaxNameBytes = 64;
constexpr std::size_t kMaxReasonBytes = 400;
/// Silence of its holder after which the lease ends, ns and ms.
constexpr std::int64_t kLease_ns = 2000 * wire::kMillisecond_ns;
constexpr std::uint32_t kLease_ms = 2000;

}  // namespace

std::optional<v1::Result> Lease::refusal(const Session& session, const v1::Item& item) const {
  if (session.role == wire::Role::kView && wire::needs_control(item)) {
    return result_of(v1::RESULT_CODE_NOT_PERMITTED, {},
                     "the view key may look and listen; connect with the control key");
  }
  if (!wire::needs_lease(item)) return std::nullopt;
  if (!held_by(session)) return not_owner(session);
  if (item.fence() != 0 && item.fence() != fence_) {
    return result_of(v1::RESULT_CODE_NOT_OWNER, {}, "the lease with this fence is over");
  }
  return std::nullopt;
}

v1::Result Lease::not_owner(const Session& session) const {
  return result_of(v1::RESULT_CODE_NOT_OWNER, {},
                   session.serial == lost_by_ ? "the lease was taken over by '" + holder_ + "'"
                                              : "acquire the lease first");
}

std::optional<v1::Result> Lease::fault_of(const v1::Acquire& request) {
  const auto fault = [](const std::string& path, const std::string& text, std::size_t most) {
    if (text.size() > most) {
      return std::optional(result_of(v1::RESULT_CODE_OUT_OF_RANGE, path,
                                     "at most " + std::to_string(most) + " bytes"));
    }
    if (wire::is_plain(text)) return std::optional<v1::Result>();
    return std::optional(
        result_of(v1::RESULT_CODE_INVALID, path, "a text is UTF-8 without control characters"));
  };
  std::optional<v1::Result> found = fault("acquire.holder", request.holder(), kMaxNameBytes);
  if (!found) found = fault("acquire.take_over", request.take_over(), kMaxReasonBytes);
  return found;
}

Lease::Granted Lease::acquire(const Session& session, const v1::Acquire& request) {
  if (std::optional<v1::Result> fault = fault_of(request)) return {std::move(*fault)};
  const bool takes_over = session_ != 0 && !request.take_over().empty();
  if (session_ != 0 && !held_by(session) && !takes_over) {
    return {result_of(
        v1::RESULT_CODE_BUSY, {},
        "the lease is held by '" + holder_ + "': wait for LeaseInfo, or take it over and say why")};
  }
  const bool granted_anew = takes_over || !held_by(session);
  Granted granted{result_of(v1::RESULT_CODE_OK), granted_anew || holder_ != request.holder()};
  if (granted_anew) {
    ++fence_;
    taken_from_ = takes_over ? holder_ : "";
    reason_ = takes_over ? request.take_over() : "";
    lost_by_ = takes_over && !held_by(session) ? session_ : 0;
    granted.lost_by = lost_by_;
  }
  session_ = session.serial;
  holder_ = request.holder();
  key_name_ = session.key_name;
  renewed_ns_ = sessions_.now_ns();
  *granted.result.mutable_lease() = info(session);
  if (takes_over) host_.lease_lost(LeaseEnd::kTakenOver);
  return granted;
}

void Lease::renew(const Session& session) noexcept {
  if (held_by(session)) renewed_ns_ = sessions_.now_ns();
}

void Lease::give_up(const Session& session, LeaseEnd how) {
  if (held_by(session)) end(how);
}

void Lease::expire() {
  if (session_ == 0 || sessions_.now_ns() - renewed_ns_ <= kLease_ns) return;
  const Session* holder = sessions_.find(session_);
  if (holder != nullptr && holder->runs_steps()) return;
  end(LeaseEnd::kExpired);
}

void Lease::end(LeaseEnd how) {
  session_ = 0;
  lost_by_ = 0;
  holder_.clear();
  tell();
  host_.lease_lost(how);
}

v1::LeaseInfo Lease::info() const {
  v1::LeaseInfo info;
  info.set_ttl_ms(kLease_ms);
  if (session_ == 0) return info;
  info.set_fence(fence_);
  info.set_holder(holder_);
  info.set_key_name(key_name_);
  info.set_taken_from(taken_from_);
  info.set_reason(reason_);
  return info;
}

v1::LeaseInfo Lease::info(const Session& session) const {
  v1::LeaseInfo own = info();
  own.set_yours(held_by(session));
  return own;
}

void Lease::tell() {
  if (host_.lease_told) host_.lease_told(info());
  for (const auto& session : sessions_.all()) {
    sessions_.serve(*session, [&] {
      v1::Item item;
      *item.mutable_lease_info() = info(*session);
      sessions_.tell(*session, item);
    });
  }
}

}  // namespace hapticd
