// See page_lease.h.
#include "clients/web/gateway/page_lease.h"

namespace hapticd::web {
namespace {

v1::Result refusal(v1::ResultCode code, const char* message) {
  v1::Result result;
  result.set_code(code);
  result.set_message(message);
  return result;
}

v1::Result only_looks() {
  return refusal(
      v1::RESULT_CODE_NOT_PERMITTED,
      "this page may only look. Open the address with the token that haptic-web printed, "
      "on its machine or by https");
}

}  // namespace

RequestNeed need_of(const v1::Item& request) {
  switch (request.body_case()) {
    case v1::Item::kGetParameters:
    case v1::Item::kListScenes:
    case v1::Item::kListGestures:
    case v1::Item::kListRecordings:
    case v1::Item::kGetDeviceInfo:
    case v1::Item::kPing:
      return RequestNeed::kNothing;
    case v1::Item::kAcquire:
    case v1::Item::kStop:
      return RequestNeed::kControl;
    case v1::Item::kRelease:
    case v1::Item::kEngage:
    case v1::Item::kDisengage:
    case v1::Item::kClear:
    case v1::Item::kLoadScene:
    case v1::Item::kSetParameter:
    case v1::Item::kRun:
    case v1::Item::kPlayGesture:
    case v1::Item::kReplay:
    case v1::Item::kRecord:
    case v1::Item::kCalibrate:
    case v1::Item::kRecentre:
    case v1::Item::kClutch:
      return RequestNeed::kLease;
    default:
      // Subscribe and Bye would be everyone's, a PoseBatch has no answer when it is taken.
      return RequestNeed::kUnsupported;
  }
}

std::optional<v1::Result> PageLease::refuse(ViewerId viewer, bool control,
                                            const v1::Item& request) const {
  const RequestNeed need = need_of(request);
  if (need == RequestNeed::kUnsupported) {
    return refusal(v1::RESULT_CODE_UNSUPPORTED, "not from a page");
  }
  if (need == RequestNeed::kNothing) return std::nullopt;
  if (!control) return only_looks();
  if (request.has_acquire()) {
    const bool taken = (holder_ != 0 && holder_ != viewer) || (asking_ != 0 && asking_ != viewer);
    if (taken) return refusal(v1::RESULT_CODE_BUSY, "another page has control");
    return std::nullopt;
  }
  if (need == RequestNeed::kLease && holder_ != viewer) {
    return refusal(v1::RESULT_CODE_NOT_OWNER,
                   holder_ != 0 ? "another page has control" : "take control first");
  }
  return std::nullopt;
}

std::optional<v1::Result> PageLease::refuse_show(ViewerId viewer, bool control) const {
  if (!control) return only_looks();
  // A recording may also be seen where no daemon is, which would give the lease.
  if (holder_ == 0 || holder_ == viewer) return std::nullopt;
  return refusal(v1::RESULT_CODE_NOT_OWNER, "another page has control");
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
