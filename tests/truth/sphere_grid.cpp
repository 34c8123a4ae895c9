// See sphere_grid.h.
#include "tests/truth/sphere_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapticd {
namespace {

/// A sphere this much larger than the median is looked at always. Smaller: more of those; larger:
/// more memory.
constexpr double kLarge = 16.0;
/// Cells of a grid, at most.
constexpr double kMaxCells = 4e6;
/// Smallest side of a cell, m.
constexpr double kMinSide = 1e-6;
/// Widens a query, so that rounding hides no sphere, in sides of a cell.
constexpr double kRounding = 1e-6;

double median_radius(const std::vector<Sphere>& spheres) {
  std::vector<double> radii;
  radii.reserve(spheres.size());
  for (const Sphere& sphere : spheres) radii.push_back(sphere.r);
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return *middle;
}

}  // namespace

SphereGrid::SphereGrid(std::vector<Sphere> spheres) : spheres_(std::move(spheres)) {
  if (spheres_.empty()) return;
  choose_cells();
  fill();
}

void SphereGrid::choose_cells() {
  const double median = median_radius(spheres_);
  side_ = std::max(2.0 * median, kMinSide);
  Vector3 upper = Vector3::Constant(-1e300);
  lower_ = -upper;
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    const Sphere& sphere = spheres_[i];
    if (sphere.r > kLarge * side_) {
      large_.push_back(static_cast<std::uint32_t>(i));
      continue;
    }
    lower_ = lower_.cwiseMin(sphere.p - Vector3::Constant(sphere.r));
    upper = upper.cwiseMax(sphere.p + Vector3::Constant(sphere.r));
  }
  if (large_.size() == spheres_.size()) return;
  const Vector3 extent = upper - lower_;
  const auto count = [&](double side) { return (extent / side + Vector3::Ones()).prod(); };
  while (count(side_) > kMaxCells) side_ *= 2.0;
  for (std::size_t k = 0; k < 3; ++k) {
    cells_[k] = 1 + static_cast<std::int64_t>(extent[static_cast<Eigen::Index>(k)] / side_);
  }
}

// First counts the entries of each cell, then puts them in their places.
void SphereGrid::fill() {
  begin_.assign(static_cast<std::size_t>(cells_[0] * cells_[1] * cells_[2]) + 1, 0);
  const auto for_each_cell = [this](const auto& visit) {
    auto next_large = large_.begin();
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      if (next_large != large_.end() && *next_large == i) {
        ++next_large;
        continue;
      }
      const Block block = block_of(spheres_[i].p, spheres_[i].r);
      for (std::int64_t x = block.lower[0]; x <= block.upper[0]; ++x) {
        for (std::int64_t y = block.lower[1]; y <= block.upper[1]; ++y) {
          for (std::int64_t z = block.lower[2]; z <= block.upper[2]; ++z) {
            visit(row_of(x, y) + static_cast<std::size_t>(z), i);
          }
        }
      }
    }
  };
  for_each_cell([this](std::size_t cell, std::size_t) { ++begin_[cell + 1]; });
  for (std::size_t cell = 1; cell < begin_.size(); ++cell) begin_[cell] += begin_[cell - 1];
  entries_.resize(begin_.back());
  std::vector<std::size_t> place(begin_.begin(), begin_.end() - 1);
  for_each_cell([&](std::size_t cell, std::size_t i) {
    entries_[place[cell]++] = static_cast<std::uint32_t>(i);
  });
}

bool SphereGrid::nothing_near(const Vector3& p, double radius) const {
  for (const std::uint32_t i : large_) {
    const double near = radius + spheres_[i].r + kRounding * side_;
    if ((spheres_[i].p - p).squaredNorm() <= near * near) return false;
  }
  const Block block = block_of(p, radius);
  for (std::int64_t x = block.lower[0]; x <= block.upper[0]; ++x) {
    for (std::int64_t y = block.lower[1]; y <= block.upper[1]; ++y) {
      const std::size_t row = row_of(x, y);
      if (begin_[row + static_cast<std::size_t>(block.lower[2])] !=
          begin_[row + static_cast<std::size_t>(block.upper[2]) + 1]) {
        return false;
      }
    }
  }
  return true;
}

SphereGrid::Block SphereGrid::block_of(const Vector3& p, double radius) const {
  Block block;
  const double half = radius + kRounding * side_;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const double last = static_cast<double>(cells_[k] - 1);
    const double from = std::floor((p[axis] - half - lower_[axis]) / side_);
    const double to = std::floor((p[axis] + half - lower_[axis]) / side_);
    if (!(to >= 0.0 && from <= last)) return {{0, 0, 0}, {-1, -1, -1}};
    block.lower[k] = static_cast<std::int64_t>(std::max(from, 0.0));
    block.upper[k] = static_cast<std::int64_t>(std::min(to, last));
  }
  return block;
}

}  // namespace hapticd
