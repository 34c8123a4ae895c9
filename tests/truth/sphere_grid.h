// Spheres sorted into cells of space, so that an exhaustive search may leave out what is certainly
// far. Shares no code with core/collision. Frame: that of the spheres. SI. Not RT.
#pragma once

#include <array>
#include <cstdint>
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
    for (const std::uint32_t i : large_) visit(static_cast<std::size_t>(i));
    const Block block = block_of(p, radius);
    for (std::int64_t x = block.lower[0]; x <= block.upper[0]; ++x) {
      for (std::int64_t y = block.lower[1]; y <= block.upper[1]; ++y) {
        // Cells that follow each other along z lie side by side.
        const std::size_t row = row_of(x, y);
        const std::size_t last = begin_[row + static_cast<std::size_t>(block.upper[2]) + 1];
        for (std::size_t k = begin_[row + static_cast<std::size_t>(block.lower[2])]; k < last;
             ++k) {
          visit(static_cast<std::size_t>(entries_[k]));
        }
      }
    }
  }

  /// True: no sphere's surface is nearer to `p` than `radius`, and none contains it. False says
  /// nothing.
  [[nodiscard]] bool nothing_near(const Vector3& p, double radius) const;

 private:
  /// Cells that a cube around a place meets; none when an upper one is below its lower one.
  struct Block {
    std::array<std::int64_t, 3> lower{};
    std::array<std::int64_t, 3> upper{};
  };
  [[nodiscard]] Block block_of(const Vector3& p, double radius) const;
  [[nodiscard]] std::size_t row_of(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((x * cells_[1] + y) * cells_[2]);
  }
  void choose_cells();
  void fill();

  std::vector<Sphere> spheres_;
  std::vector<std::uint32_t> large_;  ///< spheres that would fill too many cells
  Vector3 lower_{0.0, 0.0, 0.0};      ///< corner of the grid
  double side_ = 1.0;                 ///< of a cell, m
  std::array<std::int64_t, 3> cells_{0, 0, 0};
  std::vector<std::size_t> begin_;      ///< of each cell among the entries; one more at the end
  std::vector<std::uint32_t> entries_;  ///< spheres, cell by cell
};

}  // namespace hapticd
