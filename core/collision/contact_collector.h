// Gathers the contacts nearer than the margin. When there are more than the capacity it keeps the
// nearest (by gap, then key) in a binary heap, and the margin shrinks to the nearest omitted.
// RT: yes; O(1) per contact, O(log kMaxCandidates) once full.
#pragma once

#include <algorithm>
#include <array>
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
  /// A contact that is kept, by its place.
  struct Kept {
    double gap;
    std::int32_t place;
  };

  [[nodiscard]] const ContactKey& key_of(const Kept& kept) const noexcept {
    return out_.contacts[static_cast<std::size_t>(kept.place)].key;
  }

  /// Nearer first; equal gaps by key, so that the choice depends on the pairs alone.
  static bool nearer(double gap_a, const ContactKey& a, double gap_b,
                     const ContactKey& b) noexcept {
    if (gap_a != gap_b) return gap_a < gap_b;
    const auto order = [](const ContactKey& k) {
      return std::tuple{k.kind, k.obstacle, k.tool_sphere, k.obstacle_sphere};
    };
    return order(a) < order(b);
  }
  [[nodiscard]] bool nearer(const Kept& a, const Kept& b) const noexcept {
    return nearer(a.gap, key_of(a), b.gap, key_of(b));
  }

  void make_heap() noexcept {
    std::int32_t place = 0;
    for (const Contact& contact : out_.contacts) {
      heap_[static_cast<std::size_t>(place)] = {contact.gap, place};
      ++place;
    }
    std::make_heap(heap_.begin(), heap_.end(),
                   [this](const Kept& a, const Kept& b) { return nearer(a, b); });
    is_heap_ = true;
  }

  /// Moves the first of the heap down to where it belongs.
  void sift_down() noexcept {
    const Kept moving = heap_.front();
    std::size_t i = 0;
    for (;;) {
      std::size_t child = 2 * i + 1;
      if (child >= heap_.size()) break;
      if (child + 1 < heap_.size() && nearer(heap_[child], heap_[child + 1])) ++child;
      if (!nearer(moving, heap_[child])) break;
      heap_[i] = heap_[child];
      i = child;
    }
    heap_[i] = moving;
  }

  [[gnu::noinline]] void replace_farthest(const Contact& contact) noexcept {
    if (!is_heap_) make_heap();
    Kept& farthest = heap_.front();
    if (!nearer(contact.gap, contact.key, farthest.gap, key_of(farthest))) {
      out_.covered_margin = std::min(margin(), contact.gap);
      return;
    }
    out_.covered_margin = std::min(margin(), farthest.gap);
    out_.contacts[static_cast<std::size_t>(farthest.place)] = contact;
    farthest.gap = contact.gap;
    sift_down();
  }

  ContactSet& out_;
  const DisplacedParts* displaced_ = nullptr;
  int index_ = -1;
  double nearest_ = std::numeric_limits<double>::infinity();
  bool is_heap_ = false;
  /// Once full: the farthest first. Of places, for contacts are large.
  std::array<Kept, kMaxCandidates> heap_;
};

}  // namespace hapticd
