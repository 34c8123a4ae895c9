// See sphere_grid.h.
#include "server/lab/truth/sphere_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapticd {
namespace {

/// A sphere that meets more cells than this is looked at always. Fewer: more of those; more:
/// memory.
constexpr double kMostCells = 512.0;
/// Smallest side of a cell, m.
constexpr double kSmallestSide = 1e-6;
/// Widens a query, so that rounding hides no sphere, in sides of a cell.
constexpr double kRounding = 1e-6;
/// Cells beyond this are one, so that far places have a number too.
constexpr double kFarthestCell = 1e12;

std::int64_t cell_of(double x, double side) {
  return static_cast<std::int64_t>(std::clamp(std::floor(x / side), -kFarthestCell, kFarthestCell));
}

double median_radius(const std::vector<Sphere>& spheres) {
  std::vector<double> radii;
  radii.reserve(spheres.size());
  for (const Sphere& sphere : spheres) radii.push_back(sphere.r);
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return *middle;
}

}  // namespace

std::size_t SphereGrid::CellHash::operator()(const Cell& cell) const noexcept {
  std::uint64_t hash = 0;
  for (const std::int64_t k : cell) {
    hash = (hash ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 29U;
  }
  return static_cast<std::size_t>(hash);
}

SphereGrid::SphereGrid(std::vector<Sphere> spheres) : spheres_(std::move(spheres)) {
  if (spheres_.empty()) return;
  side_ = std::max(2.0 * median_radius(spheres_), kSmallestSide);
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    const auto index = static_cast<std::uint32_t>(i);
    const Block block = block_of(spheres_[i].p, spheres_[i].r);
    if (block.cells > kMostCells) {
      large_.push_back(index);
      continue;
    }
    for (std::int64_t x = block.lower[0]; x <= block.upper[0]; ++x) {
      for (std::int64_t y = block.lower[1]; y <= block.upper[1]; ++y) {
        for (std::int64_t z = block.lower[2]; z <= block.upper[2]; ++z) {
          cells_[{x, y, z}].push_back(index);
        }
      }
    }
  }
}

SphereGrid::Block SphereGrid::block_of(const Vector3& p, double radius) const {
  Block block;
  block.cells = 1.0;
  const double half = radius + kRounding * side_;
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = p[static_cast<Eigen::Index>(k)];
    block.lower[k] = cell_of(x - half, side_);
    block.upper[k] = cell_of(x + half, side_);
    block.cells *= static_cast<double>(block.upper[k] - block.lower[k] + 1);
  }
  return block;
}

}  // namespace hapticd
