// See field_descriptor.h.
#include "device/pid/field_descriptor.h"

#include <algorithm>

#include "device/report_io/descriptor_item.h"

namespace hapticd::pid {
namespace {

/// Bound of what a sane device stacks.
constexpr std::size_t kDeepestStack = 4;
constexpr std::size_t kWidestField = 32;
constexpr std::size_t kIdBits = 8;

/// Bits of a main item.
constexpr std::uint32_t kConstant = 1U << 0U;
constexpr std::uint32_t kVariable = 1U << 1U;

struct Globals {
  std::uint32_t usage_page = 0;
  std::int64_t minimum = 0;
  std::int64_t maximum = 0;           ///< as a signed number
  std::int64_t maximum_unsigned = 0;  ///< as another one
  std::uint32_t report_size = 0;
  std::uint32_t report_count = 0;
  std::uint8_t report_id = 0;
};

/// One of four bytes has its own page.
struct Usage {
  std::uint32_t value = 0;
  bool has_page = false;
};

class Reader {
 public:
  explicit Reader(Descriptor& descriptor) : descriptor_(descriptor) {}

  DescriptorFlaw take(const DescriptorItem& item) {
    const DescriptorFlaw flaw = take_item(item);
    if (is_main(item.kind)) usages_.clear();
    return flaw;
  }
  [[nodiscard]] bool is_closed() const { return collection_ == -1; }

 private:
  DescriptorFlaw take_item(const DescriptorItem& item) {
    switch (item.kind) {
      case ItemKind::kInput:
        return add(ReportKind::kInput, item.value);
      case ItemKind::kOutput:
        return add(ReportKind::kOutput, item.value);
      case ItemKind::kFeature:
        return add(ReportKind::kFeature, item.value);
      case ItemKind::kCollection:
        return open();
      case ItemKind::kEndCollection:
        if (collection_ == -1) return DescriptorFlaw::kUnbalanced;
        collection_ = descriptor_.collections[static_cast<std::size_t>(collection_)].parent;
        return DescriptorFlaw::kNone;
      case ItemKind::kPush:
        if (stack_.size() == kDeepestStack) return DescriptorFlaw::kUnbalanced;
        stack_.push_back(globals_);
        return DescriptorFlaw::kNone;
      case ItemKind::kPop:
        if (stack_.empty()) return DescriptorFlaw::kUnbalanced;
        globals_ = stack_.back();
        stack_.pop_back();
        return DescriptorFlaw::kNone;
      default:
        return note(item);
    }
  }

  DescriptorFlaw note(const DescriptorItem& item) {
    switch (item.kind) {
      case ItemKind::kUsagePage:
        globals_.usage_page = item.value;
        break;
      case ItemKind::kMinimum:
        globals_.minimum = item.signed_value;
        break;
      case ItemKind::kMaximum:
        globals_.maximum = item.signed_value;
        globals_.maximum_unsigned = item.value;
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
        note_usage({item.value, item.data_bytes == 4});
        break;
      case ItemKind::kFirstUsage:
        first_ = {item.value, item.data_bytes == 4};
        break;
      case ItemKind::kLastUsage:
        note_usages_to(item.value);
        break;
      default:
        break;  // of no consequence for the place of a field
    }
    return DescriptorFlaw::kNone;
  }

  void note_usage(Usage usage) {
    if (usages_.size() < kMaxUsages) usages_.push_back(usage);
  }

  void note_usages_to(std::uint32_t last) {
    for (std::uint64_t usage = first_.value; usage <= last && usages_.size() < kMaxUsages;
         ++usage) {
      note_usage({static_cast<std::uint32_t>(usage), first_.has_page});
    }
  }

  /// The page that counts is the one in force at the main item, not the one before the usage.
  [[nodiscard]] std::uint32_t resolve(Usage usage) const {
    return usage.has_page ? usage.value : usage_of(globals_.usage_page, usage.value);
  }

  DescriptorFlaw open() {
    if (descriptor_.collections.size() == kMaxCollections) return DescriptorFlaw::kTooLarge;
    const std::uint32_t usage = usages_.empty() ? 0 : resolve(usages_[0]);
    descriptor_.collections.push_back({usage, collection_});
    collection_ = static_cast<int>(descriptor_.collections.size()) - 1;
    return DescriptorFlaw::kNone;
  }

  /// The report of this kind that is being described, a new one if need be; null: too many.
  ReportSize* report(ReportKind kind) {
    for (ReportSize& known : descriptor_.reports) {
      if (known.kind == kind && known.id == globals_.report_id) return &known;
    }
    if (descriptor_.reports.size() == kMaxReports) return nullptr;
    descriptor_.reports.push_back(
        {kind, globals_.report_id, globals_.report_id != 0 ? kIdBits : 0});
    return &descriptor_.reports.back();
  }

  DescriptorFlaw add(ReportKind kind, std::uint32_t flags) {
    ReportSize* const size = report(kind);
    if (size == nullptr) return DescriptorFlaw::kTooLarge;
    // Both factors have 32 bits.
    const std::uint64_t bits = std::uint64_t{globals_.report_size} * globals_.report_count;
    if (bits > 8 * kMaxReportRead) return DescriptorFlaw::kTooLarge;
    const std::size_t start = size->bits;
    size->bits += bits;
    if (size->bits > 8 * kMaxReportRead) return DescriptorFlaw::kTooLarge;
    const bool is_data =
        (flags & kConstant) == 0 && globals_.report_size <= kWidestField && bits != 0;
    const std::int64_t maximum =
        globals_.minimum < 0 ? globals_.maximum : globals_.maximum_unsigned;
    if (!is_data || maximum < globals_.minimum) return DescriptorFlaw::kNone;
    Field field{kind,    globals_.report_id,       start, globals_.report_size, globals_.minimum,
                maximum, (flags & kVariable) == 0, {},    collection_};
    return field.is_array ? add_array(field) : add_variables(field);
  }

  DescriptorFlaw add_array(Field& field) {
    if (descriptor_.fields.size() == kMaxFields) return DescriptorFlaw::kTooLarge;
    field.usages.reserve(usages_.size());
    for (const Usage& usage : usages_) field.usages.push_back(resolve(usage));
    descriptor_.fields.push_back(field);
    return DescriptorFlaw::kNone;
  }

  /// Variables that have a usage of their own; the others nobody can look for.
  DescriptorFlaw add_variables(Field& field) {
    const std::size_t count = std::min<std::size_t>(globals_.report_count, usages_.size());
    for (std::size_t i = 0; i < count; ++i) {
      if (descriptor_.fields.size() == kMaxFields) return DescriptorFlaw::kTooLarge;
      field.usages = {resolve(usages_[i])};
      descriptor_.fields.push_back(field);
      field.bit += field.bits;
    }
    return DescriptorFlaw::kNone;
  }

  Descriptor& descriptor_;
  Globals globals_;
  std::vector<Globals> stack_;
  std::vector<Usage> usages_;
  Usage first_;
  int collection_ = -1;
};

DescriptorFlaw read(std::span<const std::uint8_t> bytes, Descriptor& descriptor) {
  if (bytes.size() > kMaxDescriptor) return DescriptorFlaw::kTooLong;
  Reader reader(descriptor);
  while (!bytes.empty()) {
    DescriptorItem item;
    if (!next_item(bytes, item)) return DescriptorFlaw::kCutOff;
    if (const DescriptorFlaw flaw = reader.take(item); flaw != DescriptorFlaw::kNone) return flaw;
  }
  return reader.is_closed() ? DescriptorFlaw::kNone : DescriptorFlaw::kUnbalanced;
}

}  // namespace

Descriptor read_fields(std::span<const std::uint8_t> bytes) {
  Descriptor descriptor;
  const DescriptorFlaw flaw = read(bytes, descriptor);
  if (flaw != DescriptorFlaw::kNone) {
    descriptor = {};
    descriptor.flaw = flaw;
  }
  return descriptor;
}

bool is_within(const Descriptor& descriptor, int collection, std::uint32_t usage) {
  while (collection != -1) {
    const Collection& at = descriptor.collections[static_cast<std::size_t>(collection)];
    if (at.usage == usage) return true;
    collection = at.parent;
  }
  return false;
}

}  // namespace hapticd::pid
