// See field_descriptor.h.
#include "device/pid/field_descriptor.h"

#include <algorithm>

namespace hapticd::pid {
namespace {

constexpr std::size_t kWidestField = 32;
constexpr std::size_t kIdBits = 8;

/// Bits of a main item.
constexpr std::uint32_t kConstant = 1U << 0U;
constexpr std::uint32_t kVariable = 1U << 1U;
constexpr std::uint32_t kRelative = 1U << 2U;
/// Type of a collection.
constexpr std::uint32_t kApplication = 1;

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
        return open(item.value);
      case ItemKind::kEndCollection:
        if (collection_ == -1) return DescriptorFlaw::kUnbalanced;
        collection_ = descriptor_.collections[static_cast<std::size_t>(collection_)].parent;
        return DescriptorFlaw::kNone;
      case ItemKind::kUsage:
        note_usage(named_usage(item));
        return DescriptorFlaw::kNone;
      case ItemKind::kFirstUsage:
        first_ = named_usage(item);
        return DescriptorFlaw::kNone;
      case ItemKind::kLastUsage:
        note_usages_to(item.value);
        return DescriptorFlaw::kNone;
      default:
        return globals_.take(item);
    }
  }

  void note_usage(NamedUsage usage) {
    if (usages_.size() < kMaxUsages) usages_.push_back(usage);
  }

  void note_usages_to(std::uint32_t last) {
    for (std::uint64_t usage = first_.value; usage <= last && usages_.size() < kMaxUsages;
         ++usage) {
      note_usage({static_cast<std::uint32_t>(usage), first_.has_page});
    }
  }

  DescriptorFlaw open(std::uint32_t type) {
    if (descriptor_.collections.size() == kMaxCollections) return DescriptorFlaw::kTooLarge;
    const std::uint32_t usage = usages_.empty() ? 0 : globals_->resolve(usages_[0]);
    descriptor_.collections.push_back({usage, collection_, type == kApplication});
    collection_ = static_cast<int>(descriptor_.collections.size()) - 1;
    return DescriptorFlaw::kNone;
  }

  /// The report of this kind that is being described, a new one if need be; null: too many.
  ReportSize* report(ReportKind kind) {
    for (ReportSize& known : descriptor_.reports) {
      if (known.kind == kind && known.id == globals_->report_id) return &known;
    }
    if (descriptor_.reports.size() == kMaxReports) return nullptr;
    descriptor_.reports.push_back(
        {kind, globals_->report_id, globals_->report_id != 0 ? kIdBits : 0});
    return &descriptor_.reports.back();
  }

  DescriptorFlaw add(ReportKind kind, std::uint32_t flags) {
    ReportSize* const size = report(kind);
    if (size == nullptr) return DescriptorFlaw::kTooLarge;
    const std::uint64_t bits = globals_->bits();
    if (bits > 8 * kMaxReportRead) return DescriptorFlaw::kTooLarge;
    const std::size_t start = size->bits;
    size->bits += bits;
    if (size->bits > 8 * kMaxReportRead) return DescriptorFlaw::kTooLarge;
    const bool is_data =
        (flags & kConstant) == 0 && globals_->report_size <= kWidestField && bits != 0;
    const std::int64_t maximum =
        globals_->minimum < 0 ? globals_->maximum : globals_->maximum_unsigned;
    if (!is_data || maximum < globals_->minimum) return DescriptorFlaw::kNone;
    Field field{kind,
                globals_->report_id,
                start,
                globals_->report_size,
                globals_->minimum,
                maximum,
                (flags & kVariable) == 0,
                (flags & kRelative) != 0,
                {},
                collection_};
    return field.is_array ? add_array(field) : add_variables(field);
  }

  DescriptorFlaw add_array(Field& field) {
    if (descriptor_.fields.size() == kMaxFields) return DescriptorFlaw::kTooLarge;
    field.usages.reserve(usages_.size());
    for (const NamedUsage& usage : usages_) field.usages.push_back(globals_->resolve(usage));
    descriptor_.fields.push_back(field);
    return DescriptorFlaw::kNone;
  }

  /// Variables that have their own usage; the others cannot be looked for.
  DescriptorFlaw add_variables(Field& field) {
    const std::size_t count = std::min<std::size_t>(globals_->report_count, usages_.size());
    for (std::size_t i = 0; i < count; ++i) {
      if (descriptor_.fields.size() == kMaxFields) return DescriptorFlaw::kTooLarge;
      field.usages = {globals_->resolve(usages_[i])};
      descriptor_.fields.push_back(field);
      field.bit += field.bits;
    }
    return DescriptorFlaw::kNone;
  }

  Descriptor& descriptor_;
  GlobalItems globals_;
  std::vector<NamedUsage> usages_;
  NamedUsage first_;
  int collection_ = -1;
};

}  // namespace

Descriptor read_fields(std::span<const std::uint8_t> bytes) {
  Descriptor descriptor;
  Reader reader(descriptor);
  const DescriptorFlaw flaw = read_items(bytes, reader);
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

int application_of(const Descriptor& descriptor, int collection) {
  while (collection != -1) {
    const Collection& at = descriptor.collections[static_cast<std::size_t>(collection)];
    if (at.is_application) return collection;
    collection = at.parent;
  }
  return -1;
}

bool is_inside(const Descriptor& descriptor, int collection, int outer) {
  while (collection != -1 && collection != outer) {
    collection = descriptor.collections[static_cast<std::size_t>(collection)].parent;
  }
  return collection == outer;
}

}  // namespace hapticd::pid
