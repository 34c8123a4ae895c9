// See report_descriptor.h.
#include "device/hid/report_descriptor.h"

#include "device/hid/profile_v1.h"
#include "device/report_io/descriptor_item.h"

namespace hapticd::hid {
namespace {

/// Bounds of what a sane device nests, and what Linux keeps: stacked globals, open collections,
/// longest report in bytes.
constexpr std::size_t kDeepestStack = 4;
constexpr std::size_t kDeepestCollection = 64;
constexpr std::uint64_t kMaxReport = 16384;

constexpr std::uint32_t kApplication = 0x01;
constexpr unsigned kPageShift = 16;
constexpr std::uint32_t kHapticUsage = std::uint32_t{kUsagePage} << kPageShift | kUsage;

struct Globals {
  std::uint32_t usage_page = 0;
  std::uint32_t report_size = 0;
  std::uint32_t report_count = 0;
  std::uint8_t report_id = 0;
};

class Reader {
 public:
  explicit Reader(DescriptorFacts& facts) noexcept : facts_(facts) {}

  DescriptorFlaw take(const DescriptorItem& item) noexcept {
    const DescriptorFlaw flaw = take_item(item);
    if (is_main(item.kind)) has_usage_ = false;
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
      case ItemKind::kPush:
        return stack_.push_back(globals_) ? DescriptorFlaw::kNone : DescriptorFlaw::kUnbalanced;
      case ItemKind::kPop:
        if (stack_.empty()) return DescriptorFlaw::kUnbalanced;
        globals_ = stack_[stack_.size() - 1];
        stack_.truncate(stack_.size() - 1);
        return DescriptorFlaw::kNone;
      default:
        return note(item);
    }
  }

  DescriptorFlaw note(const DescriptorItem& item) noexcept {
    switch (item.kind) {
      case ItemKind::kUsagePage:
        globals_.usage_page = item.value;
        break;
      case ItemKind::kReportSize:
        globals_.report_size = item.value;
        break;
      case ItemKind::kReportCount:
        globals_.report_count = item.value;
        break;
      case ItemKind::kReportId:
        if (item.value == 0 || item.value > 0xFF) return DescriptorFlaw::kBadReportId;
        globals_.report_id = static_cast<std::uint8_t>(item.value);
        break;
      case ItemKind::kUsage:
        note_usage(item);
        break;
      default:
        break;  // of no consequence for sizes and usages
    }
    return DescriptorFlaw::kNone;
  }

  /// The first usage before a collection is the collection's; one of four bytes has its own page.
  void note_usage(const DescriptorItem& item) noexcept {
    if (has_usage_) return;
    has_usage_ = true;
    usage_ = item.value;
    has_page_ = item.data_bytes == 4;
  }

  DescriptorFlaw open(std::uint32_t type) noexcept {
    if (depth_ == kDeepestCollection) return DescriptorFlaw::kUnbalanced;
    // The page that counts is the one in force here, not the one before the usage.
    const std::uint32_t usage = has_page_ ? usage_ : globals_.usage_page << kPageShift | usage_;
    if (depth_ == 0 && type == kApplication && has_usage_ && usage == kHapticUsage) {
      facts_.is_haptic = true;
    }
    ++depth_;
    return DescriptorFlaw::kNone;
  }

  DescriptorFlaw add(ReportKind kind) noexcept {
    // Both factors have 32 bits.
    const std::uint64_t bits = std::uint64_t{globals_.report_size} * globals_.report_count;
    if (bits > 8 * kMaxReport) return DescriptorFlaw::kTooLarge;
    for (ReportSize& report : facts_.reports) {
      if (report.kind != kind || report.id != globals_.report_id) continue;
      report.bits += bits;
      return report.bits > 8 * kMaxReport ? DescriptorFlaw::kTooLarge : DescriptorFlaw::kNone;
    }
    const bool fits = facts_.reports.push_back({kind, globals_.report_id, bits});
    return fits ? DescriptorFlaw::kNone : DescriptorFlaw::kTooLarge;
  }

  DescriptorFacts& facts_;
  Globals globals_;
  FixedVector<Globals, kDeepestStack> stack_;
  std::size_t depth_ = 0;
  std::uint32_t usage_ = 0;
  bool has_usage_ = false;
  bool has_page_ = false;
};

DescriptorFlaw read(std::span<const std::uint8_t> bytes, DescriptorFacts& facts) noexcept {
  if (bytes.size() > kMaxDescriptor) return DescriptorFlaw::kTooLong;
  Reader reader(facts);
  while (!bytes.empty()) {
    DescriptorItem item;
    if (!next_item(bytes, item)) return DescriptorFlaw::kCutOff;
    if (const DescriptorFlaw flaw = reader.take(item); flaw != DescriptorFlaw::kNone) return flaw;
  }
  return reader.is_closed() ? DescriptorFlaw::kNone : DescriptorFlaw::kUnbalanced;
}

}  // namespace

std::uint64_t bytes_of(const ReportSize& report) noexcept {
  return (report.bits + 7) / 8 + (report.id != 0 ? 1 : 0);
}

DescriptorFacts read_descriptor(std::span<const std::uint8_t> descriptor) noexcept {
  DescriptorFacts facts;
  const DescriptorFlaw flaw = read(descriptor, facts);
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
