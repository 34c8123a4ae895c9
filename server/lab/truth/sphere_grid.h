// Spheres sorted into cells of space, so that an exhaustive search may leave out what is certainly
// far. Shares no code with core/collision. Frame: that of the spheres. SI. Not RT.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/geometry/sphere.h"

namespace hapticd {

class SphereGrid {
 public:
  explicit SphereGrid(std::vector<Sphere> spheres);

  [[nodiscard]] const std::vector<Sphere>& spheres() const noexcept { return spheres_; }

  /// Calls visit(index) for at least every sphere whose surface is nearer to `p` than `radius`, or
  /// that contains `p`; for some of them several times.
  template <typename Visit>
  void visit_near(const Vector3& p, double radius, const Visit& visit) const {
    const Block block = block_of(p, radius);
    if (block.cells > static_cast<double>(cells_.size())) {
      for (std::size_t i = 0; i < spheres_.size(); ++i) visit(i);
      return;
    }
    for (const std::uint32_t i : large_) visit(static_cast<std::size_t>(i));
    for (std::int64_t x = block.lower[0]; x <= block.upper[0]; ++x) {
      for (std::int64_t y = block.lower[1]; y <= block.upper[1]; ++y) {
        for (std::int64_t z = block.lower[2]; z <= block.upper[2]; ++z) {
          const auto cell = cells_.find({x, y, z});
          if (cell == cells_.end()) continue;
          for (const std::uint32_t i : cell->second) visit(static_cast<std::size_t>(i));
        }
      }
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& cell) const noexcept;
  };
  /// Cells that a cube around a place meets.
  struct Block {
    Cell lower{}, upper{};
    double cells = 0.0;
  };
  [[nodiscard]] Block block_of(const Vector3& p, double radius) const;

  std::vector<Sphere> spheres_;
  double side_ = 1.0;  ///< of a cell, m
  std::unordered_map<Cell, std::vector<std::uint32_t>, CellHash> cells_;
  std::vector<std::uint32_t> large_;  ///< spheres that would fill too many cells
};

}  // namespace hapticd
