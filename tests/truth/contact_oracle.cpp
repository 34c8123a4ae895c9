// See contact_oracle.h.
#include "tests/truth/contact_oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/collision/obstacles.h"

namespace hapticd {
namespace {

using Real = long double;
using Real3 = std::array<Real, 3>;
using Real33 = std::array<Real3, 3>;  // rows

/// A pose in long double.
struct OraclePose {
  Real33 R;
  Real3 p;
};

constexpr Real kInfinity = std::numeric_limits<Real>::infinity();

Real3 to_real(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
Real3 operator-(const Real3& a, const Real3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Real3 operator+(const Real3& a, const Real3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Real3 operator*(Real s, const Real3& a) { return {s * a[0], s * a[1], s * a[2]}; }
Real dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real3 operator*(const Real33& R, const Real3& v) {
  return {dot(R[0], v), dot(R[1], v), dot(R[2], v)};
}

struct RealQuaternion {
  Real w;
  Real3 v;
};

RealQuaternion normalised(const Quaternion& q) {
  const RealQuaternion p{q.w(), {q.x(), q.y(), q.z()}};
  const Real n = std::sqrt(p.w * p.w + dot(p.v, p.v));
  return {p.w / n, (1 / n) * p.v};
}

RealQuaternion multiply(const RealQuaternion& a, const RealQuaternion& b) {
  const Real3 cross{a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2],
                    a.v[0] * b.v[1] - a.v[1] * b.v[0]};
  return {a.w * b.w - dot(a.v, b.v), a.w * b.v + b.w * a.v + cross};
}

Real33 matrix(const RealQuaternion& q) {
  const Real w = q.w;
  const auto [x, y, z] = q.v;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

OraclePose real_pose(const Pose& X) { return {matrix(normalised(X.q)), to_real(X.p)}; }

struct PointDistance {
  Real3 offset;
  Real distance;
  Real lambda;
};

PointDistance to_segment(const Real3& A, const Real3& B, const Real3& C) {
  const Real3 AB = B - A;
  const Real square = dot(AB, AB);
  const Real lambda = square > 0 ? std::clamp(dot(C - A, AB) / square, Real{0}, Real{1}) : Real{0};
  const Real3 offset = C - (A + lambda * AB);
  return {offset, std::sqrt(dot(offset, offset)), lambda};
}

PointDistance to_point(const Real3& P, const Real3& C) {
  const Real3 offset = C - P;
  return {offset, std::sqrt(dot(offset, offset)), 0};
}

/// Plain-old-data sphere, for the fast pass in double.
struct FlatSphere {
  double x, y, z, r;
};

std::vector<FlatSphere> placed_spheres(std::span<const Sphere> spheres, const OraclePose& X,
                                       const Real3& origin) {
  std::vector<FlatSphere> result;
  result.reserve(spheres.size());
  for (const Sphere& sphere : spheres) {
    const Real3 p = X.R * to_real(sphere.p) + (X.p - origin);
    result.push_back({static_cast<double>(p[0]), static_cast<double>(p[1]),
                      static_cast<double>(p[2]), sphere.r});
  }
  return result;
}

/// Largest coordinate, for the error of the fast pass.
double extent(const std::vector<FlatSphere>& spheres) {
  double result = 0.0;
  for (const FlatSphere& s : spheres) {
    result = std::max({result, std::abs(s.x), std::abs(s.y), std::abs(s.z), s.r});
  }
  return result;
}

/// Error of the fast pass in units of the largest coordinate: far above its rounding (about 30
/// epsilon); larger only sends more pairs to the long double evaluation.
constexpr double kFastPassError = 1e-13;

/// The tool for the fast pass: centres relative to its origin.
struct FlatTool {
  FlatTool(std::span<const Sphere> tool_G, const OraclePose& X)
      : spheres_G(tool_G),
        X_WG(X),
        flat(placed_spheres(tool_G, X, X.p)),
        largest(hapticd::extent(flat)) {}

  [[nodiscard]] Real3 centre_W(std::size_t i) const {
    return X_WG.R * to_real(spheres_G[i].p) + X_WG.p;
  }

  std::span<const Sphere> spheres_G;
  const OraclePose& X_WG;
  std::vector<FlatSphere> flat;
  double largest;  ///< coordinate, m
};

/// Smallest gap of the tool to one capsule, if below `best`.
Real minimum_to_capsule(const FlatTool& placed, const Capsule& capsule, Real best) {
  const OraclePose& X_WG = placed.X_WG;
  const std::vector<FlatSphere>& tool = placed.flat;
  const Vector3 a =
      capsule.p_A - Vector3(static_cast<double>(X_WG.p[0]), static_cast<double>(X_WG.p[1]),
                            static_cast<double>(X_WG.p[2]));
  const Vector3 e = capsule.p_B - capsule.p_A;
  const double square = e.squaredNorm();
  const Vector3 u = square > 0.0 ? Vector3(e / square) : Vector3(0.0, 0.0, 0.0);
  const double error = kFastPassError * (placed.largest + a.cwiseAbs().maxCoeff() +
                                         e.cwiseAbs().maxCoeff() + capsule.r);
  for (std::size_t i = 0; i < tool.size(); ++i) {
    const double dx = tool[i].x - a.x();
    const double dy = tool[i].y - a.y();
    const double dz = tool[i].z - a.z();
    const double lambda = std::clamp(dx * u.x() + dy * u.y() + dz * u.z(), 0.0, 1.0);
    const double ox = dx - lambda * e.x();
    const double oy = dy - lambda * e.y();
    const double oz = dz - lambda * e.z();
    const double gap = std::sqrt(ox * ox + oy * oy + oz * oz) - tool[i].r - capsule.r;
    if (gap > static_cast<double>(best) + error) continue;
    const PointDistance nearest =
        to_segment(to_real(capsule.p_A), to_real(capsule.p_B), placed.centre_W(i));
    best = std::min(best, nearest.distance - tool[i].r - capsule.r);
  }
  return best;
}

/// Smallest gap of the tool to one body, if below `best`.
Real minimum_to_body(const FlatTool& placed, const OracleBody& body, Real best) {
  const std::vector<FlatSphere>& tool = placed.flat;
  const OraclePose X_WB = real_pose(body.X_WB);
  const std::vector<FlatSphere> spheres = placed_spheres(body.spheres_B, X_WB, placed.X_WG.p);
  const double error = kFastPassError * (placed.largest + extent(spheres));
  for (std::size_t i = 0; i < tool.size(); ++i) {
    for (std::size_t j = 0; j < spheres.size(); ++j) {
      const double dx = tool[i].x - spheres[j].x;
      const double dy = tool[i].y - spheres[j].y;
      const double dz = tool[i].z - spheres[j].z;
      const double near =
          std::max(0.0, static_cast<double>(best) + error + tool[i].r + spheres[j].r);
      if (dx * dx + dy * dy + dz * dz > near * near) continue;
      const Real3 P = X_WB.R * to_real(body.spheres_B[j].p) + X_WB.p;
      best = std::min(best,
                      to_point(P, placed.centre_W(i)).distance - tool[i].r - body.spheres_B[j].r);
    }
  }
  return best;
}

/// What the sum of (1 - (d - phi) / width)^3 over the distances is 1 for.
Real blended_distance(const std::vector<Real>& distances, Real width) {
  Real high = *std::min_element(distances.begin(), distances.end());
  Real low = high - width;
  for (int k = 0; k < 64; ++k) {
    const Real phi = (low + high) / 2;
    Real sum = 0;
    for (const Real d : distances) {
      const Real share = std::max(Real{0}, 1 - (d - phi) / width);
      sum += share * share * share;
    }
    (sum > 1 ? high : low) = phi;
  }
  return low;
}

/// Smallest gap of the tool to one body whose spheres blend, if below `best`.
Real minimum_to_blend(const FlatTool& placed, const OracleBody& body, Real best) {
  const OraclePose X_WB = real_pose(body.X_WB);
  std::vector<Real3> centres;
  for (const Sphere& sphere : body.spheres_B) {
    centres.push_back(X_WB.R * to_real(sphere.p) + X_WB.p);
  }
  const std::vector<FlatSphere> flat = placed_spheres(body.spheres_B, X_WB, placed.X_WG.p);
  const double error = kFastPassError * (placed.largest + extent(flat));
  const double width = body.blend;
  std::vector<double> gaps(flat.size());
  for (std::size_t i = 0; i < placed.flat.size(); ++i) {
    const FlatSphere& tool = placed.flat[i];
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < flat.size(); ++j) {
      const double dx = tool.x - flat[j].x;
      const double dy = tool.y - flat[j].y;
      const double dz = tool.z - flat[j].z;
      gaps[j] = std::sqrt(dx * dx + dy * dy + dz * dz) - flat[j].r;
      least = std::min(least, gaps[j]);
    }
    if (!(least - width - tool.r < static_cast<double>(best) + error)) continue;
    std::vector<Real> distances;
    for (std::size_t j = 0; j < flat.size(); ++j) {
      if (gaps[j] > least + width + error) continue;
      distances.push_back(to_point(centres[j], placed.centre_W(i)).distance - body.spheres_B[j].r);
    }
    best = std::min(best, blended_distance(distances, width) - tool.r);
  }
  return best;
}

Real minimum_gap(std::span<const Sphere> tool_G, const OraclePose& X_WG,
                 const OracleObstacles& obstacles) {
  const FlatTool tool(tool_G, X_WG);
  Real best = kInfinity;
  for (const Capsule& capsule : obstacles.capsules_W) {
    best = minimum_to_capsule(tool, capsule, best);
  }
  for (const OracleBody& body : obstacles.bodies) {
    best =
        body.blend > 0.0 ? minimum_to_blend(tool, body, best) : minimum_to_body(tool, body, best);
  }
  return best;
}

/// Bound of the way of any point of the tool that is displaced by `dp` and turned by `angle`.
Real farthest_way(std::span<const Sphere> tool_G, const Real3& dp, Real angle) {
  Real arm = 0;
  for (const Sphere& sphere : tool_G) {
    const Real3 p = to_real(sphere.p);
    arm = std::max(arm, std::sqrt(dot(p, p)) + sphere.r);
  }
  return std::sqrt(dot(dp, dp)) + angle * arm;
}

/// The two legs of every string at s along the path.
void place_legs(std::span<const OracleBentString> strings, Real s, std::vector<Capsule>& legs) {
  std::size_t i = 0;
  for (const OracleBentString& string : strings) {
    const Real3 p = (1 - s) * to_real(string.p_WP_from) + s * to_real(string.p_WP_to);
    const Vector3 vertex(static_cast<double>(p[0]), static_cast<double>(p[1]),
                         static_cast<double>(p[2]));
    legs[i++] = {string.straight_W.p_A, vertex, string.straight_W.r};
    legs[i++] = {vertex, string.straight_W.p_B, string.straight_W.r};
  }
}

/// Greatest way of any point of a string: that of its vertex.
Real string_way(std::span<const OracleBentString> strings) {
  double way = 0.0;
  for (const OracleBentString& string : strings) {
    way = std::max(way, (string.p_WP_to - string.p_WP_from).norm());
  }
  return way;
}

/// Greatest way of any sphere within the tool.
Real part_way(std::span<const Sphere> from_G, std::span<const Sphere> to_G) {
  double way = 0.0;
  for (std::size_t i = 0; i < from_G.size(); ++i) {
    way = std::max(way, (to_G[i].p - from_G[i].p).norm());
  }
  return way;
}

/// The tool's spheres at s along the path.
void place_parts(std::span<const Sphere> from_G, std::span<const Sphere> to_G, Real s,
                 std::vector<Sphere>& tool_G) {
  for (std::size_t i = 0; i < from_G.size(); ++i) {
    const Real3 p = (1 - s) * to_real(from_G[i].p) + s * to_real(to_G[i].p);
    tool_G[i].p = {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  }
}

}  // namespace

OracleResult exhaustive_contacts(std::span<const Sphere> tool_G, const Pose& X_WG,
                                 const OracleObstacles& obstacles, long double margin) {
  OracleResult result{{}, kInfinity};
  const OraclePose X = real_pose(X_WG);
  const auto note = [&](const ContactKey& key, const PointDistance& nearest, Real radii) {
    const Real gap = nearest.distance - radii;
    result.minimum_gap = std::min(result.minimum_gap, gap);
    if (gap < margin) {
      result.contacts.push_back({key, gap, nearest.lambda, nearest.distance, nearest.offset});
    }
  };
  for (std::size_t i = 0; i < tool_G.size(); ++i) {
    const Real3 C = X.R * to_real(tool_G[i].p) + X.p;
    const auto tool_sphere = static_cast<TreeSphereId>(i);
    for (std::size_t k = 0; k < obstacles.capsules_W.size(); ++k) {
      const Capsule& capsule = obstacles.capsules_W[k];
      note({ObstacleKind::kCapsule, static_cast<std::int32_t>(k), tool_sphere, 0},
           to_segment(to_real(capsule.p_A), to_real(capsule.p_B), C),
           static_cast<Real>(tool_G[i].r) + capsule.r);
    }
  }
  for (std::size_t k = 0; k < obstacles.bodies.size(); ++k) {
    const OracleBody& body = obstacles.bodies[k];
    const OraclePose X_WB = real_pose(body.X_WB);
    for (std::size_t j = 0; j < body.spheres_B.size(); ++j) {
      const Real3 P = X_WB.R * to_real(body.spheres_B[j].p) + X_WB.p;
      for (std::size_t i = 0; i < tool_G.size(); ++i) {
        const Real3 C = X.R * to_real(tool_G[i].p) + X.p;
        note({ObstacleKind::kBody, static_cast<std::int32_t>(k), static_cast<TreeSphereId>(i),
              static_cast<TreeSphereId>(j)},
             to_point(P, C), static_cast<Real>(tool_G[i].r) + body.spheres_B[j].r);
      }
    }
  }
  std::sort(result.contacts.begin(), result.contacts.end(),
            [](const OracleContact& a, const OracleContact& b) {
              const auto order = [](const OracleContact& c) {
                return std::tuple{c.gap, c.key.kind, c.key.obstacle, c.key.tool_sphere,
                                  c.key.obstacle_sphere};
              };
              return order(a) < order(b);
            });
  return result;
}

long double exhaustive_minimum_gap(std::span<const Sphere> tool_G, const Pose& X_WG,
                                   const OracleObstacles& obstacles) {
  return minimum_gap(tool_G, real_pose(X_WG), obstacles);
}

long double path_minimum_gap(const OracleTool& begin, const OracleTool& end,
                             const OracleObstacles& obstacles, long double spacing) {
  const std::span<const Sphere> from_G = begin.spheres_G;
  const std::span<const Sphere> to_G = end.spheres_G;
  const Pose& X_WF = begin.X_WG;
  const Pose& X_WT = end.X_WG;
  const RealQuaternion from = normalised(X_WF.q);
  const RealQuaternion to = normalised(X_WT.q);
  RealQuaternion turn = multiply(to, {from.w, Real{-1} * from.v});
  if (turn.w < 0) turn = {-turn.w, Real{-1} * turn.v};
  const Real sine = std::sqrt(dot(turn.v, turn.v));
  const Real half_angle = std::atan2(sine, turn.w);
  const Real3 axis = sine > 0 ? (1 / sine) * turn.v : Real3{0, 0, 0};
  const Real3 p_from = to_real(X_WF.p);
  const Real3 p_to = to_real(X_WT.p);
  std::vector<Capsule> legs(2 * obstacles.bent.size());
  const Real aside = part_way(from_G, to_G);
  std::vector<Sphere> tool_G(from_G.begin(), from_G.end());
  const auto gap_at = [&](Real s) {
    const RealQuaternion part{std::cos(s * half_angle), std::sin(s * half_angle) * axis};
    const OraclePose X{matrix(multiply(part, from)), (1 - s) * p_from + s * p_to};
    if (aside > 0) place_parts(from_G, to_G, s, tool_G);
    const Real gap = minimum_gap(tool_G, X, obstacles);
    if (legs.empty()) return gap;
    place_legs(obstacles.bent, s, legs);
    return std::min(gap, minimum_gap(tool_G, X, {legs, {}}));
  };
  const Real way = std::max(farthest_way(from_G, p_to - p_from, 2 * half_angle),
                            farthest_way(to_G, p_to - p_from, 2 * half_angle)) +
                   string_way(obstacles.bent) + aside;
  Real s = 0;
  Real gap = gap_at(s);
  Real best = gap;
  while (s < 1 && gap <= way * (1 - s)) {
    s = std::min(Real{1}, s + std::min(Real{1} / 8, std::max(gap, spacing) / way));
    gap = gap_at(s);
    best = std::min(best, gap);
  }
  return best;
}

}  // namespace hapticd
