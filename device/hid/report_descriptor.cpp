// See report_descriptor.h.
#include "device/hid/report_descriptor.h"

#include "device/hid/profile_v1.h"

namespace hapticd::hid {
namespace {

/// Bounds of what a sane device nests, and what Linux keeps: stacked globals, open collections,
/// longest report in bytes.
constexpr std::size_t kDeepestStack = 4;
constexpr std::size_t kDeepestCollection = 64;
constexpr std::uint64_t kLongestReport = 16384;

/// Prefixes without their two size bits: type and tag.
constexpr unsigned kInputItem = 0x80;
constexpr unsigned kOutputItem = 0x90;
constexpr unsigned kCollectionItem = 0xA0;
constexpr unsigned kFeatureItem = 0xB0;
constexpr unsigned kEndCollectionItem = 0xC0;
constexpr unsigned kUsagePageItem = 0x04;
constexpr unsigned kReportSizeItem = 0x74;
constexpr unsigned kReportIdItem = 0x84;
constexpr unsigned kReportCountItem = 0x94;
constexpr unsigned kPushItem = 0xA4;
constexpr unsigned kPopItem = 0xB4;
constexpr unsigned kUsageItem = 0x08;
constexpr unsigned kMainType = 0x00;
constexpr unsigned kTypeMask = 0x0C;
constexpr std::uint8_t kLongItem = 0xFE;
constexpr std::uint32_t kApplication = 0x01;
constexpr unsigned kPageShift = 16;
constexpr std::uint32_t kHapticUsage = std::uint32_t{kUsagePage} << kPageShift | kUsage;

struct Item {
  unsigned prefix = 0;
  std::uint32_t value = 0;  ///< unsigned
  std::size_t data_bytes = 0;
};

struct Globals {
  std::uint32_t usage_page = 0;
  std::uint32_t report_size = 0;
  std::uint32_t report_count = 0;
  std::uint8_t report_id = 0;
};

class Reader {
 public:
  explicit Reader(DescriptorFacts& facts) noexcept : facts_(facts) {}

  DescriptorFlaw take(const Item& item) noexcept {
    const DescriptorFlaw flaw = take_item(item);
    // A main item ends the life of all local ones.
    if ((item.prefix & kTypeMask) == kMainType) has_usage_ = false;
    return flaw;
  }
  [[nodiscard]] bool is_closed() const noexcept { return depth_ == 0; }

 private:
  DescriptorFlaw take_item(const Item& item) noexcept {
    switch (item.prefix) {
      case kInputItem:
        return add(ReportKind::kInput);
      case kOutputItem:
        return add(ReportKind::kOutput);
      case kFeatureItem:
        return add(ReportKind::kFeature);
      case kCollectionItem:
        return open(item.value);
      case kEndCollectionItem:
        if (depth_ == 0) return DescriptorFlaw::kUnbalanced;
        --depth_;
        return DescriptorFlaw::kNone;
      case kPushItem:
        return stack_.push_back(globals_) ? DescriptorFlaw::kNone : DescriptorFlaw::kUnbalanced;
      case kPopItem:
        if (stack_.empty()) return DescriptorFlaw::kUnbalanced;
        globals_ = stack_[stack_.size() - 1];
        stack_.truncate(stack_.size() - 1);
        return DescriptorFlaw::kNone;
      default:
        return note(item);
    }
  }

  DescriptorFlaw note(const Item& item) noexcept {
    switch (item.prefix) {
      case kUsagePageItem:
        globals_.usage_page = item.value;
        break;
      case kReportSizeItem:
        globals_.report_size = item.value;
        break;
      case kReportCountItem:
        globals_.report_count = item.value;
        break;
      case kReportIdItem:
        if (item.value == 0 || item.value > 0xFF) return DescriptorFlaw::kBadReportId;
        globals_.report_id = static_cast<std::uint8_t>(item.value);
        break;
      case kUsageItem:
        note_usage(item);
        break;
      default:
        break;  // of no consequence for sizes and usages
    }
    return DescriptorFlaw::kNone;
  }

  /// The first usage before a collection is the collection's; one of four bytes has its own page.
  void note_usage(const Item& item) noexcept {
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
    if (bits > 8 * kLongestReport) return DescriptorFlaw::kTooLarge;
    for (ReportSize& report : facts_.reports) {
      if (report.kind != kind || report.id != globals_.report_id) continue;
      report.bits += bits;
      return report.bits > 8 * kLongestReport ? DescriptorFlaw::kTooLarge : DescriptorFlaw::kNone;
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

/// Takes the next item off the front; false when the bytes end within it. Long items, which nobody
/// uses, come out as one that means nothing.
bool next_item(std::span<const std::uint8_t>& bytes, Item& item) noexcept {
  constexpr unsigned kReserved = kTypeMask;
  const std::uint8_t prefix = bytes[0];
  if (prefix == kLongItem) {
    constexpr std::size_t kLongHead = 3;
    if (bytes.size() < kLongHead || bytes.size() - kLongHead < bytes[1]) return false;
    item = {kReserved, 0, 0};
    bytes = bytes.subspan(kLongHead + bytes[1]);
    return true;
  }
  const unsigned code = prefix & 3U;
  const std::size_t size = code == 3 ? 4 : code;
  if (bytes.size() - 1 < size) return false;
  item = {prefix & ~3U, 0, size};
  for (std::size_t i = 0; i < size; ++i) item.value |= std::uint32_t{bytes[1 + i]} << (8 * i);
  bytes = bytes.subspan(1 + size);
  return true;
}

DescriptorFlaw read(std::span<const std::uint8_t> bytes, DescriptorFacts& facts) noexcept {
  if (bytes.size() > kLongestDescriptor) return DescriptorFlaw::kTooLong;
  Reader reader(facts);
  while (!bytes.empty()) {
    Item item;
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
