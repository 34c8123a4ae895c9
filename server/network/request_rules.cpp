// See request_rules.h.
#include "server/network/request_rules.h"

namespace hapticd {

bool is_request(const v1::Item& item) {
  switch (item.body_case()) {
    case v1::Item::kSubscribe:
    case v1::Item::kPing:
    case v1::Item::kGetParameters:
    case v1::Item::kListScenes:
    case v1::Item::kListGestures:
    case v1::Item::kListRecordings:
    case v1::Item::kGetDeviceInfo:
    case v1::Item::kAcquire:
    case v1::Item::kStop:
      return true;
    default:
      return needs_lease(item);
  }
}

bool needs_lease(const v1::Item& item) {
  switch (item.body_case()) {
    case v1::Item::kRelease:
    case v1::Item::kEngage:
    case v1::Item::kDisengage:
    case v1::Item::kClear:
    case v1::Item::kLoadScene:
    case v1::Item::kSetParameter:
    case v1::Item::kPoseBatch:
    case v1::Item::kRun:
    case v1::Item::kPlayGesture:
    case v1::Item::kReplay:
    case v1::Item::kRecord:
    case v1::Item::kCalibrate:
    case v1::Item::kRecentre:
    case v1::Item::kClutch:
      return true;
    default:
      return false;
  }
}

Cost cost_of(const v1::Item& item) {
  switch (item.body_case()) {
    case v1::Item::kListScenes:
    case v1::Item::kListGestures:
    case v1::Item::kListRecordings:
      return Cost::kDear;
    case v1::Item::kGetParameters:
    case v1::Item::kGetDeviceInfo:
    case v1::Item::kSetParameter:
    case v1::Item::kPlayGesture:
    case v1::Item::kRecord:
      return Cost::kMuch;
    default:
      return Cost::kLittle;
  }
}

}  // namespace hapticd
