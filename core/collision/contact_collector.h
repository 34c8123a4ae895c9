// Gathers the contacts nearer than the margin. When there are more than the capacity it keeps the
// nearest (by gap, then key) in a binary heap, and the margin shrinks to the nearest omitted.
// RT: yes; O(1) per contact, O(log kMaxCandidates) once full.
#pragma once

#include <algorithm>
#include <limits>
#include <tuple>

#include "core/collision/contact.h"
#include "core/collision/displaced_parts.h"

namespace hapticd {

/// Fills a ContactSet's contacts, covered margin and tests.
class ContactCollector {
 public:
  /// Empties `out`, which must outlive this.
  ContactCollector(double margin, ContactSet& out) noexcept : out_(out) {
    out_.contacts.clear();
    out_.covered_margin = margin;
    out_.tests = 0;
  }

  /// Pairs whose gap is certainly not below this need not be tried, m.
  [[nodiscard]] double margin() const noexcept { return out_.covered_margin; }

  /// From now on only spheres that entry `index` of `displaced` displaces are wanted; -1: those
  /// that none does. `displaced` must outlive this.
  void look_at(const DisplacedParts& displaced, int index) noexcept {
    displaced_ = &displaced;
    index_ = index;
  }

  /// True when the contact of a pair of this sphere of the tool with this gap must be added.
  [[nodiscard]] bool wants(TreeSphereId tool_sphere, double gap) const noexcept {
    return (gap < margin() || (is_heap_ && gap <= margin())) &&
           (displaced_ == nullptr || displaced_->find(tool_sphere) == index_);
  }

  /// Adds a contact with a `gap` that wants() accepts: write(contact) fills it where it stays.
  template <typename Write>
  void add(double gap, const Write& write) noexcept {
    nearest_ = std::min(nearest_, gap);
    if (Contact* const place = out_.contacts.append(); place != nullptr) [[likely]] {
      write(*place);
    } else {
      Contact contact;
      write(contact);
      replace_farthest(contact);
    }
  }

  /// Smallest gap added, m; +infinity when none.
  [[nodiscard]] double nearest() const noexcept { return nearest_; }

  void count_tests(std::int64_t tests) noexcept { out_.tests += tests; }

 private:
  /// Nearer first; equal gaps by key, so that the choice depends on the pairs alone.
  static bool nearer(const Contact& a, const Contact& b) noexcept {
    if (a.gap != b.gap) return a.gap < b.gap;
    const auto order = [](const ContactKey& k) {
      return std::tuple{k.kind, k.obstacle, k.tool_sphere, k.obstacle_sphere};
    };
    return order(a.key) < order(b.key);
  }

  [[gnu::noinline]] void replace_farthest(const Contact& contact) noexcept {
    auto& contacts = out_.contacts;
    if (!is_heap_) {
      std::make_heap(contacts.begin(), contacts.end(), nearer);
      is_heap_ = true;
    }
    Contact* const farthest = contacts.begin();
    if (!nearer(contact, *farthest)) {
      out_.covered_margin = std::min(margin(), contact.gap);
      return;
    }
    out_.covered_margin = std::min(margin(), farthest->gap);
    std::pop_heap(contacts.begin(), contacts.end(), nearer);
    *(contacts.end() - 1) = contact;
    std::push_heap(contacts.begin(), contacts.end(), nearer);
  }

  ContactSet& out_;
  const DisplacedParts* displaced_ = nullptr;
  int index_ = -1;
  double nearest_ = std::numeric_limits<double>::infinity();
  bool is_heap_ = false;
};

}  // namespace hapticd
