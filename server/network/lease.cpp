// See lease.h.
#include "server/network/lease.h"

#include "proto/wire/request_result.h"
#include "proto/wire/request_rule.h"
#include "proto/wire/shown_text.h"

namespace hapticd {
namespace {

using wire::result_of;

constexpr std::size_t kMaxNameBytes = 64;
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
  if (!held_by(session)) {
    return result_of(v1::RESULT_CODE_NOT_OWNER, {}, "acquire the lease first");
  }
  if (item.fence() != 0 && item.fence() != fence_) {
    return result_of(v1::RESULT_CODE_NOT_OWNER, {}, "the lease with this fence is over");
  }
  return std::nullopt;
}

Lease::Granted Lease::acquire(const Session& session, const v1::Acquire& request) {
  if (request.holder().size() > kMaxNameBytes) {
    return {result_of(v1::RESULT_CODE_OUT_OF_RANGE, "acquire.holder", "at most 64 bytes")};
  }
  if (!wire::is_plain(request.holder())) {
    return {result_of(v1::RESULT_CODE_INVALID, "acquire.holder",
                      "a name is UTF-8 without control characters")};
  }
  if (session_ != 0 && !held_by(session)) {
    return {result_of(v1::RESULT_CODE_BUSY, {},
                      "the lease is held by '" + holder_ + "': wait for LeaseInfo")};
  }
  Granted granted{result_of(v1::RESULT_CODE_OK), !held_by(session) || holder_ != request.holder()};
  if (!held_by(session)) ++fence_;
  session_ = session.serial;
  holder_ = request.holder();
  renewed_ns_ = sessions_.now_ns();
  *granted.result.mutable_lease() = info(session);
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
  holder_.clear();
  tell();
  host_.lease_lost(how);
}

v1::LeaseInfo Lease::info(const Session& session) const {
  v1::LeaseInfo info;
  info.set_ttl_ms(kLease_ms);
  if (session_ == 0) return info;
  info.set_fence(fence_);
  info.set_holder(holder_);
  info.set_yours(held_by(session));
  return info;
}

void Lease::tell() {
  for (const auto& session : sessions_.all()) {
    sessions_.serve(*session, [&] {
      v1::Item item;
      *item.mutable_lease_info() = info(*session);
      sessions_.tell(*session, item);
    });
  }
}

}  // namespace hapticd
