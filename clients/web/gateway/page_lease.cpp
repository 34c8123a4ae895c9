// See page_lease.h.
#include "clients/web/gateway/page_lease.h"

#include "proto/wire/request_result.h"
#include "proto/wire/request_rule.h"

namespace hapticd::web {
v1::Result only_looks() {
  return wire::result_of(
      v1::RESULT_CODE_NOT_PERMITTED, "",
      "this page may only look. Open the address with the token that haptic-web printed, "
      "on its machine or by https");
}

std::optional<v1::Result> PageLease::refuse(ViewerId viewer, bool control,
                                            const v1::Item& request) const {
  // A Subscribe would be everyone's, a PoseBatch has no answer when it is taken.
  if (wire::rule_of(request) == nullptr || request.has_subscribe() || request.has_pose_batch()) {
    return wire::result_of(v1::RESULT_CODE_UNSUPPORTED, "", "not from a page");
  }
  if (!control) return only_looks();
  if (!wire::needs_control(request)) return std::nullopt;
  if (request.has_acquire()) {
    const bool held = holder_ != 0 && holder_ != viewer && request.acquire().take_over().empty();
    if (held || (asking_ != 0 && asking_ != viewer))
      return wire::result_of(v1::RESULT_CODE_BUSY, "", "another page has control");
    return std::nullopt;
  }
  if (wire::needs_lease(request) && holder_ != viewer) {
    return wire::result_of(v1::RESULT_CODE_NOT_OWNER, "",
                           holder_ != 0 ? "another page has control" : "take control first");
  }
  return std::nullopt;
}

std::optional<v1::Result> PageLease::refuse_show(ViewerId viewer, bool control) const {
  if (!control) return only_looks();
  // A recording may also be seen where no daemon is, which would give the lease.
  if (holder_ == 0 || holder_ == viewer) return std::nullopt;
  return wire::result_of(v1::RESULT_CODE_NOT_OWNER, "", "another page has control");
}

void PageLease::asked(ViewerId viewer, const v1::Item& request) {
  if (request.has_acquire()) asking_ = viewer;
}

void PageLease::answered(ViewerId viewer, const v1::Item& request, const v1::Result* result) {
  const bool good = result != nullptr && result->code() == v1::RESULT_CODE_OK;
  if (request.has_acquire()) {
    asking_ = 0;
    if (good) holder_ = viewer;
  }
  if (request.has_release() && good && holder_ == viewer) holder_ = 0;
}

v1::LeaseInfo PageLease::seen_by(ViewerId viewer, const v1::LeaseInfo& told) const {
  v1::LeaseInfo seen = told;
  seen.set_yours(told.yours() && holder_ == viewer);
  return seen;
}

}  // namespace hapticd::web
