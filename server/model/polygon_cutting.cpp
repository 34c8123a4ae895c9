// See polygon_cutting.h.
#include "server/model/polygon_cutting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>

namespace hapticd {
namespace {

/// How far rounding to floats moves a corner, as a share of the largest coordinate: four units in
/// the last place. Larger: narrow parts count as closed.
constexpr double kRounding = 0x1p-22;

using Plane2 = std::array<double, 2>;

/// Twice the area of the triangle a b c, positive where it turns left. Exactly 0 where two of them
/// are one.
double turn(const Plane2& a, const Plane2& b, const Plane2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double length(const Plane2& a, const Plane2& b) { return std::hypot(b[0] - a[0], b[1] - a[1]); }

/// The corners that count, in the plane of the polygon's area, which turns left there.
struct FlatPolygon {
  std::vector<std::size_t> places;  ///< in the list of corners
  std::vector<Plane2> p;
  double rounding = 0.0;  ///< of a place
};

/// Which side of the line a b the place c is on: 0 within rounding of it.
int side(const FlatPolygon& flat, const Plane2& a, const Plane2& b, const Plane2& c) {
  const double t = turn(a, b, c);
  if (std::abs(t) <= flat.rounding * length(a, b)) return 0;
  return t > 0.0 ? 1 : -1;
}

bool crosses_itself(const FlatPolygon& flat) {
  const std::size_t n = flat.p.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Plane2& a = flat.p[i];
    const Plane2& b = flat.p[(i + 1) % n];
    for (std::size_t j = i + 2; j < n; ++j) {
      const Plane2& c = flat.p[j];
      const Plane2& d = flat.p[(j + 1) % n];
      if (side(flat, a, b, c) * side(flat, a, b, d) < 0 &&
          side(flat, c, d, a) * side(flat, c, d, b) < 0) {
        return true;
      }
    }
  }
  return false;
}

/// Corners of a flat polygon, turning left.
using FlatTriangle = std::array<std::size_t, 3>;

/// What is left of a polygon while ears are cut off.
class Rest {
 public:
  explicit Rest(const FlatPolygon& flat) : flat_(flat), left_(flat.p.size()) {
    const std::size_t n = flat.p.size();
    for (std::size_t i = 0; i < n; ++i) {
      before_.push_back((i + n - 1) % n);
      after_.push_back((i + 1) % n);
    }
    hollow_.resize(n);
    for (std::size_t i = 0; i < n; ++i) judge(i);
  }

  [[nodiscard]] std::size_t size() const { return left_; }
  [[nodiscard]] std::size_t before(std::size_t i) const { return before_[i]; }
  [[nodiscard]] std::size_t after(std::size_t i) const { return after_[i]; }
  [[nodiscard]] FlatTriangle ear(std::size_t i) const { return {before_[i], i, after_[i]}; }

  /// Whether the boundary goes nowhere at corner `i`, or out and back: that covers nothing.
  [[nodiscard]] bool is_spike(std::size_t i) const {
    const Plane2& a = flat_.p[before_[i]];
    const Plane2& b = flat_.p[i];
    const Plane2& c = flat_.p[after_[i]];
    return a == b || b == c || c == a;
  }

  /// Whether the triangle at corner `i` lies inside: it turns left, and no corner is in it.
  /// `strict`: nor within rounding of its sides, and the triangle is more than rounding.
  [[nodiscard]] bool is_ear(std::size_t i, bool strict) const {
    const Plane2& a = flat_.p[before_[i]];
    const Plane2& b = flat_.p[i];
    const Plane2& c = flat_.p[after_[i]];
    if (strict ? side(flat_, a, c, b) >= 0 : turn(a, b, c) < 0.0) return false;
    for (std::size_t k = after_[after_[i]]; k != before_[i]; k = after_[k]) {
      const Plane2& q = flat_.p[k];
      // A corner that turns left is in the triangle only together with one that does not.
      if (!hollow_[k] || q == a || q == b || q == c) continue;
      const std::array<double, 3> inside{turn(a, b, q), turn(b, c, q), turn(c, a, q)};
      const double slack = strict ? flat_.rounding : 0.0;
      if (inside[0] >= -slack * length(a, b) && inside[1] >= -slack * length(b, c) &&
          inside[2] >= -slack * length(c, a)) {
        return false;
      }
    }
    return true;
  }

  void cut(std::size_t i) {
    after_[before_[i]] = after_[i];
    before_[after_[i]] = before_[i];
    --left_;
    judge(before_[i]);
    judge(after_[i]);
  }

 private:
  void judge(std::size_t i) {
    hollow_[i] = side(flat_, flat_.p[before_[i]], flat_.p[i], flat_.p[after_[i]]) <= 0;
  }

  const FlatPolygon& flat_;
  std::vector<std::size_t> before_;
  std::vector<std::size_t> after_;
  std::vector<bool> hollow_;  ///< turns right, or not at all
  std::size_t left_;
};

/// Cuts ears until nothing is left; false where there is none. Spikes first: an ear on one side of
/// a spike would leave the other side to be covered backwards.
bool cut_ears(const FlatPolygon& flat, std::vector<FlatTriangle>& triangles) {
  Rest rest(flat);
  std::size_t at = 1;
  const auto go_to = [&](auto wanted) {
    for (std::size_t tried = 0; tried < rest.size(); ++tried) {
      if (wanted(at)) return true;
      at = rest.after(at);
    }
    return false;
  };
  while (rest.size() >= 3) {
    if (!go_to([&](std::size_t i) { return rest.is_spike(i); }) &&
        !go_to([&](std::size_t i) { return rest.is_ear(i, true); }) &&
        !go_to([&](std::size_t i) { return rest.is_ear(i, false); })) {
      return false;
    }
    triangles.push_back(rest.ear(at));
    // Back, where the cut may have made an ear: going on would pass by a corridor's whole length
    // between one ear and the next.
    const std::size_t next = rest.before(at);
    rest.cut(at);
    at = next;
  }
  return true;
}

/// Triangles as the test for overlap takes them.
struct Piece {
  std::array<Plane2, 3> p;
  std::array<double, 3> edge;  ///< length of the one from each corner
  Plane2 least, most;          ///< bounds
};

/// Whether an edge of `a` has all of `b` outside, except for the rounding of both.
bool edge_parts(const Piece& a, const Piece& b, double rounding) {
  for (std::size_t k = 0; k < 3; ++k) {
    const double slack = 2.0 * rounding * a.edge[k];
    const auto outside = [&](const Plane2& q) {
      return turn(a.p[k], a.p[(k + 1) % 3], q) <= slack;
    };
    if (outside(b.p[0]) && outside(b.p[1]) && outside(b.p[2])) return true;
  }
  return false;
}

/// Two triangles are apart where a line along an edge of one parts them (Gottschalk et al.,
/// "OBBTree", SIGGRAPH 1996: separating axes).
bool overlap(const Piece& a, const Piece& b, double rounding) {
  for (std::size_t k = 0; k < 2; ++k) {
    if (a.most[k] <= b.least[k] || b.most[k] <= a.least[k]) return false;
  }
  return !edge_parts(a, b, rounding) && !edge_parts(b, a, rounding);
}

/// Whether two of the triangles cover the same place by more than rounding. Ears add up to the
/// winding number everywhere; so it is 0 or 1 where none overlap.
bool any_overlap(const FlatPolygon& flat, const std::vector<FlatTriangle>& triangles) {
  std::vector<Piece> pieces;
  for (const FlatTriangle& t : triangles) {
    Piece piece{{flat.p[t[0]], flat.p[t[1]], flat.p[t[2]]}, {}, {}, {}};
    const auto& [a, b, c] = piece.p;
    piece.edge = {length(a, b), length(b, c), length(c, a)};
    for (std::size_t k = 0; k < 2; ++k) {
      std::tie(piece.least[k], piece.most[k]) = std::minmax({a[k], b[k], c[k]});
    }
    const double longest = *std::max_element(piece.edge.begin(), piece.edge.end());
    // What is not wider than the slack overlaps nothing.
    if (turn(a, b, c) <= 2.0 * flat.rounding * longest) continue;
    for (const Piece& other : pieces) {
      if (overlap(piece, other, flat.rounding)) return true;
    }
    pieces.push_back(piece);
  }
  return false;
}

struct Measures {
  Vector3 area{0.0, 0.0, 0.0};  ///< half the sum of the cross products
  double girth = 0.0;           ///< of the edges
  double largest = 0.0;         ///< coordinate
};

Measures measure(std::span<const Vector3> corners) {
  Measures measures;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3 p = corners[i] - corners[0];
    const Vector3 q = corners[(i + 1) % corners.size()] - corners[0];
    measures.area += 0.5 * p.cross(q);
    measures.girth += (q - p).norm();
    measures.largest = std::max(measures.largest, corners[i].cwiseAbs().maxCoeff());
  }
  return measures;
}

double area_of(std::span<const Vector3> corners, const std::vector<Triangle>& triangles) {
  double area = 0.0;
  const auto corner = [&](std::int32_t k) { return corners[static_cast<std::size_t>(k)]; };
  for (const Triangle& t : triangles) {
    area += 0.5 * (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).norm();
  }
  return area;
}

FlatPolygon flatten(std::span<const Vector3> corners, const Measures& measures) {
  const Vector3 normal = measures.area / measures.area.norm();
  Eigen::Index least = 0;
  normal.cwiseAbs().minCoeff(&least);
  const Vector3 u = Vector3::Unit(least).cross(normal).normalized();
  const Vector3 v = normal.cross(u);
  FlatPolygon flat;
  flat.rounding = kRounding * measures.largest;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!flat.places.empty() && corners[i] == corners[flat.places.back()]) continue;
    if (i + 1 == corners.size() && i > 0 && corners[i] == corners[0]) continue;
    const Vector3 p = corners[i] - corners[0];
    flat.places.push_back(i);
    flat.p.push_back({u.dot(p), v.dot(p)});
  }
  return flat;
}

/// All triangles from the first corner: for what has no area to speak of.
std::vector<Triangle> fan(std::size_t corners) {
  std::vector<Triangle> triangles;
  for (std::size_t k = 2; k < corners; ++k) {
    triangles.push_back({0, static_cast<std::int32_t>(k - 1), static_cast<std::int32_t>(k)});
  }
  return triangles;
}

}  // namespace

CutPolygon cut_polygon(std::span<const Vector3> corners) {
  if (corners.size() == 3) return {fan(3), ""};
  if (corners.size() > kMaxCorners) {
    return {{}, "has more than " + std::to_string(kMaxCorners) + " corners"};
  }
  const Measures measures = measure(corners);
  const double area = measures.area.norm();
  // Of a long narrow polygon this may be more than its area: then any triangles do.
  const double rounding = kRounding * measures.largest * measures.girth;
  if (!(area > rounding)) {
    CutPolygon cut{fan(corners.size()), ""};
    if (area_of(corners, cut.triangles) <= 2.0 * rounding) return cut;
    return {{}, "crosses itself, so that its parts cancel"};
  }
  const FlatPolygon flat = flatten(corners, measures);
  if (crosses_itself(flat)) return {{}, "crosses itself"};
  std::vector<FlatTriangle> ears;
  if (!cut_ears(flat, ears) || any_overlap(flat, ears)) return {{}, "overlaps itself"};
  CutPolygon cut;
  const auto place = [&](std::size_t k) { return static_cast<std::int32_t>(flat.places[k]); };
  for (const auto& [a, b, c] : ears) cut.triangles.push_back({place(a), place(b), place(c)});
  const double cut_area = area_of(corners, cut.triangles);
  if (!(cut_area <= (1.0 + kMaxExcessArea) * area + rounding)) {
    return {{},
            "is not flat: triangles on its corners have " +
                std::to_string(static_cast<int>(100.0 * (cut_area / area - 1.0))) +
                " % more area than it has"};
  }
  return cut;
}

}  // namespace hapticd
