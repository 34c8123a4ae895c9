// See outlines.h.
#include "tests/server/model/outlines.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapticd::test {

Real shoelace(const Outline& outline) {
  Real twice = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point& a = outline[i];
    const Point& b = outline[(i + 1) % outline.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

bool contains(const Outline& outline, const Point& q) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point& a = outline[i];
    const Point& b = outline[(i + 1) % outline.size()];
    if ((a[1] > q[1]) == (b[1] > q[1])) continue;
    if (q[0] < a[0] + (q[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

Real distance(const Outline& outline, const Point& q) {
  Real nearest = 1e30L;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point& a = outline[i];
    const Point& b = outline[(i + 1) % outline.size()];
    const Point d{b[0] - a[0], b[1] - a[1]};
    const Real square = d[0] * d[0] + d[1] * d[1];
    const Real along = ((q[0] - a[0]) * d[0] + (q[1] - a[1]) * d[1]) / (square > 0 ? square : 1);
    const Real t = std::clamp<Real>(along, 0, 1);
    nearest = std::min(nearest, std::hypot(q[0] - a[0] - t * d[0], q[1] - a[1] - t * d[1]));
  }
  return nearest;
}

Outline around(SplitMix64& random, std::size_t corners, double least) {
  Outline outline;
  const Real step = 2 * std::numbers::pi_v<Real> / static_cast<Real>(corners);
  for (std::size_t i = 0; i < corners; ++i) {
    const Real angle = step * (static_cast<Real>(i) + random.uniform(-0.35, 0.35));
    const Real radius = random.uniform(least, 1.0);
    outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return outline;
}

Outline ellipse(SplitMix64& random, std::size_t corners) {
  Outline outline = around(random, corners, 1.0);
  const Real narrow = random.uniform(0.2, 1.0);
  for (Point& p : outline) p[1] *= narrow;
  return outline;
}

Outline comb(SplitMix64& random, std::size_t teeth) {
  Outline outline{{0, 0}, {static_cast<Real>(2 * teeth) - 1, 0}};
  for (std::size_t k = teeth; k-- > 0;) {
    const Real x = static_cast<Real>(2 * k);
    const Real top = random.uniform(0.5, 3.0);
    outline.push_back({x + 1, top});
    outline.push_back({x, top});
    if (k == 0) break;
    const Real floor = random.uniform(0.1, 0.4);
    outline.push_back({x, floor});
    outline.push_back({x - 1, floor});
  }
  return outline;
}

Outline stairs(SplitMix64& random, std::size_t steps) {
  Outline outline{{0, 0}};
  Real x = 0;
  Real y = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    outline.push_back({x, y + 1 + static_cast<Real>(random.below(2))});
    y = outline.back()[1];
    x -= 1 + static_cast<Real>(random.below(2));
    outline.push_back({x, y});
  }
  outline.push_back({x, 0});
  return outline;
}

Outline spiral(int turns) {
  Outline outer;
  Outline inner;
  Real x = 0;
  Real y = 0;
  Real reach = turns + 2;
  const std::array<Point, 4> ways{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  for (int k = 0; k <= turns; ++k) {
    const Point& way = ways[static_cast<std::size_t>(k) % 4];
    const Point& left = ways[static_cast<std::size_t>(k + 1) % 4];
    outer.push_back({x, y});
    inner.push_back({x + Real{0.3L} * (left[0] + (k == 0 ? 0 : way[0])),
                     y + Real{0.3L} * (left[1] + (k == 0 ? 0 : way[1]))});
    x += reach * way[0];
    y += reach * way[1];
    if (k % 2 == 1) reach -= 1;
  }
  const Point& left = ways[static_cast<std::size_t>(turns + 1) % 4];
  outer.push_back({x, y});
  outer.push_back({x + Real{0.3L} * left[0], y + Real{0.3L} * left[1]});
  outer.insert(outer.end(), inner.rbegin(), inner.rend());
  return outer;
}

Outline ring(SplitMix64& random) {
  const Real half = random.uniform(0.1, 0.8);
  Outline outline{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
  for (const Point& p : Outline{{-1, -1}, {-1, 1}, {1, 1}, {1, -1}, {-1, -1}}) {
    outline.push_back({half * p[0], half * p[1]});
  }
  return outline;
}

Outline with_corners_on_edges(SplitMix64& random, const Outline& outline) {
  Outline more;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point& a = outline[i];
    const Point& b = outline[(i + 1) % outline.size()];
    more.push_back(a);
    if (random.chance(0.5)) more.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2});
  }
  return more;
}

}  // namespace hapticd::test
