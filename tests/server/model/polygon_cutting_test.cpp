// Cutting polygons into triangles: random ones with corners on small grids, which touch, overlap
// and cross themselves in every way, are cut only where they cover each place once. Truth: winding
// numbers and a test for simplicity in whole numbers.
#include "server/model/polygon_cutting.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

using Whole = std::array<std::int64_t, 2>;
using Corners = std::vector<Whole>;

/// Between two lines of the grid. A prime, so that few sample points are on an edge.
constexpr std::int64_t kCell = 101;

std::int64_t cross(const Whole& a, const Whole& b, const Whole& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

std::int64_t twice_area(const Corners& polygon) {
  std::int64_t twice = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    twice += cross(polygon[0], polygon[i], polygon[i + 1]);
  }
  return twice;
}

bool on_line_of_edge(const Corners& polygon, const Whole& q) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Whole& next = polygon[(i + 1) % polygon.size()];
    if (polygon[i] != next && cross(polygon[i], next, q) == 0) return true;
  }
  return false;
}

/// How often `polygon` goes around `q`, which is on no edge; positive: to the left.
int winding(const Corners& polygon, const Whole& q) {
  int winding = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Whole& a = polygon[i];
    const Whole& b = polygon[(i + 1) % polygon.size()];
    if (a[1] <= q[1] && b[1] > q[1] && cross(a, b, q) > 0) ++winding;
    if (a[1] > q[1] && b[1] <= q[1] && cross(a, b, q) < 0) --winding;
  }
  return winding;
}

bool on_edge(const Whole& a, const Whole& b, const Whole& q) {
  return cross(a, b, q) == 0 && std::min(a[0], b[0]) <= q[0] && q[0] <= std::max(a[0], b[0]) &&
         std::min(a[1], b[1]) <= q[1] && q[1] <= std::max(a[1], b[1]);
}

bool meet(const Whole& a, const Whole& b, const Whole& c, const Whole& d) {
  const auto sign = [](std::int64_t x) { return (x > 0) - (x < 0); };
  return (sign(cross(a, b, c)) * sign(cross(a, b, d)) < 0 &&
          sign(cross(c, d, a)) * sign(cross(c, d, b)) < 0) ||
         on_edge(a, b, c) || on_edge(a, b, d) || on_edge(c, d, a) || on_edge(c, d, b);
}

/// No edges meet but neighbours, and those only where one follows the other.
bool is_simple(const Corners& polygon) {
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Whole& a = polygon[i];
    const Whole& b = polygon[(i + 1) % n];
    const Whole& c = polygon[(i + 2) % n];
    if (a == b || on_edge(a, b, c) || on_edge(b, c, a)) return false;
    for (std::size_t j = i + 2; j < n; ++j) {
      if ((j + 1) % n != i && meet(a, b, polygon[j], polygon[(j + 1) % n])) return false;
    }
  }
  return true;
}

/// In the plane of two vectors of whole numbers, of one length and at right angles.
std::vector<Vector3> lifted(const Corners& polygon, bool oblique) {
  const Vector3 u = oblique ? Vector3{1.0, 2.0, 2.0} : Vector3::UnitX();
  const Vector3 v = oblique ? Vector3{2.0, 1.0, -2.0} : Vector3::UnitY();
  std::vector<Vector3> corners;
  for (const Whole& p : polygon) {
    corners.emplace_back(static_cast<double>(p[0]) * u + static_cast<double>(p[1]) * v);
  }
  return corners;
}

Corners corners_of(const Corners& polygon, const Triangle& t) {
  Corners corners;
  for (const std::int32_t k : t) corners.push_back(polygon[static_cast<std::size_t>(k)]);
  return corners;
}

void check_cover(SplitMix64& random, const Corners& polygon, std::uint64_t cells,
                 const std::vector<Triangle>& triangles) {
  const auto end = static_cast<std::uint64_t>(kCell) * (cells - 1);
  for (int k = 0; k < 60; ++k) {
    const Whole q{static_cast<std::int64_t>(random.below(end)),
                  static_cast<std::int64_t>(random.below(end))};
    bool general = !on_line_of_edge(polygon, q);
    int covered = 0;
    for (const Triangle& t : triangles) {
      const Corners corners = corners_of(polygon, t);
      general = general && !on_line_of_edge(corners, q);
      covered += std::abs(winding(corners, q));
    }
    if (!general) continue;
    const int around = winding(polygon, q);
    REQUIRE(around >= 0);
    REQUIRE(around <= 1);
    REQUIRE(covered == around);
  }
}

std::string text_of(const Corners& polygon) {
  std::string text;
  for (const Whole& p : polygon) {
    text += "(" + std::to_string(p[0] / kCell) + " " + std::to_string(p[1] / kCell) + ")";
  }
  return text;
}

Corners random_polygon(SplitMix64& random, std::uint64_t cells) {
  Corners polygon(4 + random.below(7));
  for (Whole& p : polygon) {
    p = {kCell * static_cast<std::int64_t>(random.below(cells)),
         kCell * static_cast<std::int64_t>(random.below(cells))};
  }
  if (twice_area(polygon) < 0) std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

/// A corridor along a circle that grows, and back on its inner side.
std::vector<Vector3> round_spiral(std::size_t corners) {
  std::vector<Vector3> spiral(corners);
  for (std::size_t i = 0; i < corners / 2; ++i) {
    const double angle = 0.1 * static_cast<double>(i);
    const Vector3 way{std::cos(angle), std::sin(angle), 0.0};
    spiral[i] = (1.0 + angle) * way;
    spiral[corners - 1 - i] = (0.5 + angle) * way;
  }
  return spiral;
}

}  // namespace

TEST_CASE("a polygon is cut only where it covers each place once, and always where it is simple") {
  SplitMix64 random(71);
  for (const std::uint64_t cells : {3U, 4U, 20U}) {
    std::int64_t simple = 0;
    std::int64_t cut_though_not = 0;
    for (std::int64_t trial = 0; trial < scaled(600000); ++trial) {
      const Corners polygon = random_polygon(random, cells);
      const CutPolygon cut = cut_polygon(lifted(polygon, random.chance(0.5)));
      CAPTURE(text_of(polygon));
      CAPTURE(cut.fault);
      if (is_simple(polygon)) {
        REQUIRE(cut.fault.empty());
        ++simple;
      } else if (cut.fault.empty()) {
        ++cut_though_not;
      }
      if (cut.fault.empty()) check_cover(random, polygon, cells, cut.triangles);
    }
    CHECK(simple > 0);
    CHECK(cut_though_not > 0);
  }
}

TEST_CASE("a polygon that overlaps itself from a corner on is refused") {
  const std::vector<Corners> overlapping{
      {{1, 1}, {2, 0}, {2, 1}, {1, 2}, {2, 0}, {2, 2}, {1, 3}},
      {{1, 2}, {2, 1}, {3, 1}, {0, 3}, {2, 1}, {3, 1}},
      {{2, 1}, {3, 1}, {2, 2}, {3, 2}, {0, 2}, {2, 0}, {3, 1}, {0, 2}},
      {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 1}},
  };
  for (const Corners& polygon : overlapping) {
    for (const bool oblique : {false, true}) {
      std::vector<Vector3> corners = lifted(polygon, oblique);
      for (std::size_t first = 0; first < corners.size(); ++first) {
        std::rotate(corners.begin(), corners.begin() + 1, corners.end());
        CHECK(cut_polygon(corners).fault == "overlaps itself");
      }
    }
  }
}

TEST_CASE("holes joined by a bridge, spikes and corners that touch are cut") {
  const std::vector<Corners> sound{
      {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}},
      {{0, 0},
       {9, 0},
       {9, 4},
       {0, 4},
       {0, 0},
       {1, 1},
       {1, 3},
       {3, 3},
       {3, 1},
       {1, 1},
       {0, 0},
       {5, 1},
       {5, 3},
       {7, 3},
       {7, 1},
       {5, 1}},
      {{0, 0},
       {9, 0},
       {9, 4},
       {0, 4},
       {0, 0},
       {1, 1},
       {1, 3},
       {3, 3},
       {5, 3},
       {7, 3},
       {7, 1},
       {5, 1},
       {5, 3},
       {3, 3},
       {3, 1},
       {1, 1}},
      {{0, 0}, {1, 0}, {3, 0}, {1, 0}, {1, 1}, {0, 1}},
      {{0, 0}, {2, 0}, {1, 1}, {2, 0}, {2, 2}, {0, 2}},
      {{0, 0}, {4, 0}, {2, 2}, {4, 4}, {0, 4}, {2, 2}},
  };
  for (const Corners& polygon : sound) {
    for (const bool oblique : {false, true}) {
      std::vector<Vector3> corners = lifted(polygon, oblique);
      for (std::size_t first = 0; first < corners.size(); ++first) {
        std::rotate(corners.begin(), corners.begin() + 1, corners.end());
        CHECK(cut_polygon(corners).fault.empty());
      }
    }
  }
}

TEST_CASE("a spiral of as many corners as there may be is cut") {
  const std::vector<Vector3> corners = round_spiral(kMaxCorners);
  const CutPolygon cut = cut_polygon(corners);
  REQUIRE(cut.fault.empty());
  REQUIRE(cut.triangles.size() == corners.size() - 2);
  double covered = 0.0;
  for (const Triangle& t : cut.triangles) {
    const auto p = [&](std::size_t k) { return corners[static_cast<std::size_t>(t[k])]; };
    const double area = 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).z();
    REQUIRE(area > 0.0);
    covered += area;
  }
  double area = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    area += 0.5 * corners[i].cross(corners[(i + 1) % corners.size()]).z();
  }
  CHECK(covered == within(area, 1e-9));
}

}  // namespace hapticd::test
