// Which surface spheres of a tool a query has looked at, where one look at each is enough: against
// a blended surface a tool sphere has one gap, however many of its leaves are near. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/collision/descent.h"

namespace hapticd {

/// Spheres of the tool's nodes, as far as they can be remembered.
class SeenSpheres {
 public:
  SeenSpheres() noexcept { seen_.fill({kNone, 0}); }

  /// Children of the tool's node that have certainly been looked at, a bit each.
  [[nodiscard]] unsigned of(const TreePart& tool) const noexcept {
    const Entry& entry = entry_of(tool);
    return entry.node == tool.node ? entry.lanes : 0U;
  }

  /// Child `i` of the node is looked at now.
  void add(const TreePart& tool, int i) noexcept {
    Entry& entry = seen_[place_of(tool)];
    if (entry.node != tool.node) {
      forgot_ = forgot_ || entry.node != kNone;
      entry = {tool.node, 0};
    }
    entry.lanes |= 1U << i;
  }

  /// Whether one may have been looked at of which nothing is known.
  [[nodiscard]] bool forgot() const noexcept { return forgot_; }

 private:
  static constexpr std::int32_t kNone = -1;
  static constexpr std::size_t kPlaces = 64;
  struct Entry {
    std::int32_t node;
    unsigned lanes;
  };

  [[nodiscard]] static std::size_t place_of(const TreePart& tool) noexcept {
    return static_cast<std::size_t>(tool.node) % kPlaces;
  }
  [[nodiscard]] const Entry& entry_of(const TreePart& tool) const noexcept {
    return seen_[place_of(tool)];
  }

  std::array<Entry, kPlaces> seen_;
  bool forgot_ = false;
};

}  // namespace hapticd
