// Gathers the contacts nearer than the margin. When there are more than kMaxCandidates it keeps the
// nearest (by gap, then key), and the margin shrinks to the nearest omitted. There is room for some
// more, so that they are chosen many at a time. RT: yes; O(1) per contact, and for some thirty ns
// each once crowded.
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

  /// True when this sphere of the tool is among those wanted.
  [[nodiscard]] bool counts(TreeSphereId tool_sphere) const noexcept {
    return displaced_ == nullptr || displaced_->find(tool_sphere) == index_;
  }

  /// True when the contact of a pair of this sphere of the tool with this gap must be added.
  [[nodiscard]] bool wants(TreeSphereId tool_sphere, double gap) const noexcept {
    return (gap < margin() || (crowded_ && gap <= margin())) && counts(tool_sphere);
  }

  /// Whether there is one of that pair already. O(contacts).
  [[nodiscard]] bool holds(const ContactKey& key) const noexcept {
    return std::any_of(out_.contacts.begin(), out_.contacts.end(),
                       [&key](const Contact& contact) { return contact.key == key; });
  }

  /// Adds a contact with a `gap` that wants() accepts: write(contact) fills it where it stays.
  template <typename Write>
  void add(double gap, const Write& write) noexcept {
    nearest_ = std::min(nearest_, gap);
    if (out_.contacts.full()) [[unlikely]]
      drop_farthest();
    write(*out_.contacts.append());
  }

  /// Ends the gathering.
  void finish() noexcept {
    if (out_.contacts.size() > kMaxCandidates) drop_farthest();
  }

  /// Smallest gap added, m; +infinity when none.
  [[nodiscard]] double nearest() const noexcept { return nearest_; }

  void count_tests(std::int64_t tests) noexcept { out_.tests += tests; }

 private:
  /// A contact, by its place.
  struct Placed {
    double gap;
    std::int32_t place;
  };

  /// Nearer first; equal gaps by key, so that the choice depends on the pairs alone.
  [[nodiscard]] bool nearer(const Placed& a, const Placed& b) const noexcept {
    if (a.gap != b.gap) return a.gap < b.gap;
    const auto order = [this](const Placed& placed) {
      const ContactKey& k = out_.contacts[static_cast<std::size_t>(placed.place)].key;
      return std::tuple{k.kind, k.obstacle, k.tool_sphere, k.obstacle_sphere};
    };
    return order(a) < order(b);
  }

  /// Drops all but the kMaxCandidates nearest; the margin becomes the gap of the nearest dropped.
  [[gnu::noinline]] void drop_farthest() noexcept {
    const std::size_t count = out_.contacts.size();
    for (std::size_t c = 0; c < count; ++c) {
      by_gap_[c] = {out_.contacts[c].gap, static_cast<std::int32_t>(c)};
    }
    const auto dropped = by_gap_.begin() + kMaxCandidates;
    const auto end = by_gap_.begin() + static_cast<std::ptrdiff_t>(count);
    std::nth_element(by_gap_.begin(), dropped, end,
                     [this](const Placed& a, const Placed& b) { return nearer(a, b); });
    out_.covered_margin = std::min(margin(), dropped->gap);
    // What stays beyond the capacity takes the places of what goes within it.
    auto hole = dropped;
    for (auto kept = by_gap_.begin(); kept != dropped; ++kept) {
      if (kept->place < kMaxCandidates) continue;
      while (hole->place >= kMaxCandidates) ++hole;
      out_.contacts[static_cast<std::size_t>(hole->place)] =
          out_.contacts[static_cast<std::size_t>(kept->place)];
      ++hole;
    }
    out_.contacts.truncate(kMaxCandidates);
    crowded_ = true;
  }

  ContactSet& out_;
  const DisplacedParts* displaced_ = nullptr;
  int index_ = -1;
  double nearest_ = std::numeric_limits<double>::infinity();
  bool crowded_ = false;  ///< some were dropped
  std::array<Placed, decltype(ContactSet::contacts)::capacity()> by_gap_;
};

}  // namespace hapticd
