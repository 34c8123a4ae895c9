// See descriptor_reader.h.
#include "device/report_io/descriptor_reader.h"

namespace hapticd {

DescriptorFlaw GlobalItems::take(const DescriptorItem& item) noexcept {
  switch (item.kind) {
    case ItemKind::kUsagePage:
      now_.usage_page = item.value;
      break;
    case ItemKind::kMinimum:
      now_.minimum = item.signed_value;
      break;
    case ItemKind::kMaximum:
      now_.maximum = item.signed_value;
      now_.maximum_unsigned = item.value;
      break;
    case ItemKind::kReportSize:
      now_.report_size = item.value;
      break;
    case ItemKind::kReportCount:
      now_.report_count = item.value;
      break;
    case ItemKind::kReportId:
      if (item.value == 0 || item.value > 0xFF) return DescriptorFlaw::kBadReportId;
      now_.report_id = static_cast<std::uint8_t>(item.value);
      break;
    case ItemKind::kPush:
      return stack_.push_back(now_) ? DescriptorFlaw::kNone : DescriptorFlaw::kUnbalanced;
    case ItemKind::kPop:
      if (stack_.empty()) return DescriptorFlaw::kUnbalanced;
      now_ = stack_[stack_.size() - 1];
      stack_.truncate(stack_.size() - 1);
      break;
    default:
      break;
  }
  return DescriptorFlaw::kNone;
}

}  // namespace hapticd
