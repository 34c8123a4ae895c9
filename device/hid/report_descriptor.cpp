// See report_descriptor.h.
#include "device/hid/report_descriptor.h"

#include <optional>

#include "device/hid/profile_v1.h"

namespace hapticd::hid {
namespace {

/// Bound of what a sane device nests.
constexpr std::size_t kDeepestCollection = 64;

constexpr std::uint32_t kApplication = 0x01;
constexpr std::uint32_t kHapticUsage = usage_of(kUsagePage, kUsage);

class Reader {
 public:
  explicit Reader(DescriptorFacts& facts) noexcept : facts_(facts) {}

  DescriptorFlaw take(const DescriptorItem& item) noexcept {
    const DescriptorFlaw flaw = take_item(item);
    if (is_main(item.kind)) usage_.reset();
    return flaw;
  }
  [[nodiscard]] bool is_closed() const noexcept { return depth_ == 0; }

 private:
  DescriptorFlaw take_item(const DescriptorItem& item) noexcept {
    switch (item.kind) {
      case ItemKind::kInput:
        return add(ReportKind::kInput);
      case ItemKind::kOutput:
        return add(ReportKind::kOutput);
      case ItemKind::kFeature:
        return add(ReportKind::kFeature);
      case ItemKind::kCollection:
        return open(item.value);
      case ItemKind::kEndCollection:
        if (depth_ == 0) return DescriptorFlaw::kUnbalanced;
        --depth_;
        return DescriptorFlaw::kNone;
      case ItemKind::kUsage:  // the first one before a collection is the collection's
        if (!usage_) usage_ = named_usage(item);
        return DescriptorFlaw::kNone;
      default:
        return globals_.take(item);
    }
  }

  DescriptorFlaw open(std::uint32_t type) noexcept {
    if (depth_ == kDeepestCollection) return DescriptorFlaw::kUnbalanced;
    if (depth_ == 0 && type == kApplication && usage_ &&
        globals_->resolve(*usage_) == kHapticUsage) {
      facts_.is_haptic = true;
    }
    ++depth_;
    return DescriptorFlaw::kNone;
  }

  DescriptorFlaw add(ReportKind kind) noexcept {
    const std::uint64_t bits = globals_->bits();
    if (bits > 8 * kMaxReportRead) return DescriptorFlaw::kTooLarge;
    for (ReportSize& report : facts_.reports) {
      if (report.kind != kind || report.id != globals_->report_id) continue;
      report.bits += bits;
      return report.bits > 8 * kMaxReportRead ? DescriptorFlaw::kTooLarge : DescriptorFlaw::kNone;
    }
    const bool fits = facts_.reports.push_back({kind, globals_->report_id, bits});
    return fits ? DescriptorFlaw::kNone : DescriptorFlaw::kTooLarge;
  }

  DescriptorFacts& facts_;
  GlobalItems globals_;
  std::size_t depth_ = 0;
  std::optional<NamedUsage> usage_;
};

}  // namespace

std::uint64_t bytes_of(const ReportSize& report) noexcept {
  return (report.bits + 7) / 8 + (report.id != 0 ? 1 : 0);
}

DescriptorFacts read_descriptor(std::span<const std::uint8_t> descriptor) noexcept {
  DescriptorFacts facts;
  Reader reader(facts);
  const DescriptorFlaw flaw = read_items(descriptor, reader);
  if (flaw != DescriptorFlaw::kNone) {
    facts = {};
    facts.flaw = flaw;
  }
  return facts;
}

bool is_profile_v1(const DescriptorFacts& facts, bool* affine) noexcept {
  struct Expected {
    ReportKind kind;
    std::uint8_t id;
    std::size_t bytes;
  };
  constexpr std::array<Expected, 5> kExpected{
      {{ReportKind::kInput, kStateId, kStateBytes},
       {ReportKind::kOutput, kCommandId, kCommandBytes},
       {ReportKind::kFeature, kCapabilitiesId, kCapabilitiesBytes},
       {ReportKind::kFeature, kConfigId, kConfigBytes},
       {ReportKind::kFeature, kCalibrationId, kCalibrationBytes}}};
  const auto has = [&facts](const Expected& expected) {
    for (const ReportSize& report : facts.reports) {
      if (report.kind == expected.kind && report.id == expected.id) {
        return bytes_of(report) == expected.bytes;
      }
    }
    return false;
  };
  bool all = facts.flaw == DescriptorFlaw::kNone && facts.is_haptic;
  for (const Expected& expected : kExpected) all = all && has(expected);
  if (affine != nullptr) *affine = all && has({ReportKind::kOutput, kAffineId, kAffineBytes});
  return all;
}

}  // namespace hapticd::hid
