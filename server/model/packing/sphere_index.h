// Which spheres reach a point: a tree of boxes over the centres with the largest radius below each.
// Offline; queries allocate nothing themselves and may run in many threads at once.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"

namespace hapticd {

/// The sphere that reaches a point most.
struct NearestSphere {
  double gap = std::numeric_limits<double>::infinity();  ///< |p - centre| - r, negative inside, m
  std::int32_t sphere = -1;
};

class SphereIndex {
 public:
  /// `spheres` is copied; may be empty; radii may be negative (weights). O(n log n).
  explicit SphereIndex(std::span<const Sphere> spheres);

  /// Sphere of the smallest gap to `p`, of equal ones the lowest.
  [[nodiscard]] NearestSphere nearest(const Vector3& p) const noexcept;

  /// Whether `p` lies deeper than `depth` inside a sphere other than `except`.
  [[nodiscard]] bool inside_another(const Vector3& p, std::int32_t except, double depth) const;

  /// Appends all spheres whose gap to `p` is at most `gap`, in an order fixed by the spheres.
  void within(const Vector3& p, double gap, std::vector<std::int32_t>& found) const;

 private:
  struct Node {
    Vector3 low, high;  ///< of the centres
    double r;           ///< largest radius below
    std::int32_t first;
    std::int32_t count;  ///< of spheres from `first`; 0: the nodes `first` and `first` + 1
  };
  struct Item {
    Vector3 p;
    double r;
    std::int32_t id;
  };
  static double least_gap(const Node& node, const Vector3& p) noexcept;
  /// Calls visit(id, gap) for the spheres whose gap to `p` is at most `gap` until one returns true.
  template <typename Visit>
  bool any_within(const Vector3& p, double gap, const Visit& visit) const;

  std::vector<Item> items_;
  std::vector<Node> nodes_;
};

}  // namespace hapticd
