// See surface_ripple.h.
#include "server/model/surface_ripple.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/collision/blended_surface.h"
#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// Patches looked at; half of their side, m, which is to hold some leaves and little of the shape;
/// places along a side.
constexpr std::size_t kPatches = 200;
constexpr double kHalfSide = 6e-3;
constexpr int kSide = 9;
/// A patch counts that its quadratic surface leaves by no more than this, m: no edge in it.
constexpr double kLargestDeparture = 1.5e-3;
/// Steps onto the surface, and how near they have to come, m.
constexpr int kSteps = 40;
constexpr double kOnSurface = 1e-8;
/// Width at which a blend is the union of its leaves for any purpose here, m.
constexpr double kUnion = 1e-6;
constexpr int kPlaces = kSide * kSide;
constexpr int kTerms = 6;

/// A place of the tip's centre.
struct Place {
  Vector3 p;
  Vector3 nhat;
};

/// From `p` along `way` (unit) to where the tip touches; none where it does not.
std::optional<Place> touch(const SphereTreeView& tree, Vector3 p, const Vector3& way) {
  for (int k = 0; k < kSteps; ++k) {
    const BlendedPlace place = place_beside_blend(tree, p);
    const double off = kRippleTip - place.distance;
    if (std::abs(off) < kOnSurface) return Place{p, place.nhat_B};
    const double slope = place.nhat_B.dot(way);
    if (off < 0.0 && slope < 0.3) return std::nullopt;
    p += way * (off / std::max(slope, 0.5));
  }
  return std::nullopt;
}

/// A direction that depends on k alone, and all together about everywhere: the golden spiral.
Vector3 direction(std::size_t k) {
  const double y = 1.0 - 2.0 * (static_cast<double>(k) + 0.5) / static_cast<double>(kPatches);
  const double turn = 2.399963229728653 * static_cast<double>(k);
  const double across = std::sqrt(1.0 - y * y);
  return {across * std::cos(turn), y, across * std::sin(turn)};
}

/// Rms of height and angle in the patch around `middle`.
std::optional<SurfaceRipple> ripple_of(const SphereTreeView& tree, const Place& middle) {
  const Vector3 n = middle.nhat;
  const Vector3 e = fixed_normal(n);
  const Vector3 f = n.cross(e);
  Eigen::Matrix<double, kPlaces, kTerms> terms;
  Eigen::Matrix<double, kPlaces, 1> height;
  std::array<Vector3, kPlaces> normal;
  for (int k = 0; k < kPlaces; ++k) {
    const int row = k / kSide;
    const double x = kHalfSide * (2.0 * (k % kSide) / (kSide - 1) - 1.0);
    const double y = kHalfSide * (2.0 * row / (kSide - 1) - 1.0);
    const std::optional<Place> place = touch(tree, middle.p + x * e + y * f, n);
    if (!place) return std::nullopt;
    terms.row(k) << 1.0, x, y, x * x, x * y, y * y;
    height[k] = n.dot(place->p - middle.p);
    normal[static_cast<std::size_t>(k)] = place->nhat;
  }
  const Eigen::Matrix<double, kTerms, 1> c = terms.colPivHouseholderQr().solve(height);
  const Eigen::Matrix<double, kPlaces, 1> off = height - terms * c;
  if (off.cwiseAbs().maxCoeff() > kLargestDeparture) return std::nullopt;
  double angles = 0.0;
  for (int k = 0; k < kPlaces; ++k) {
    const double x = terms(k, 1);
    const double y = terms(k, 2);
    const Vector3 smooth =
        n - (c[1] + 2.0 * c[3] * x + c[4] * y) * e - (c[2] + c[4] * x + 2.0 * c[5] * y) * f;
    const double angle = smooth.cross(normal[static_cast<std::size_t>(k)]).norm() / smooth.norm();
    angles += angle * angle;
  }
  return SurfaceRipple{std::sqrt(off.squaredNorm() / kPlaces), std::sqrt(angles / kPlaces), 1};
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

SurfaceRipple measure_ripple(const SphereTree& tree) {
  SphereTreeView view = tree.view();
  if (!(view.blend.width > 0.0)) view.blend.width = kUnion;
  std::vector<double> heights;
  std::vector<double> angles;
  for (std::size_t k = 0; k < kPatches; ++k) {
    const Sphere leaf = view.leaf(static_cast<std::int32_t>(k * view.leaf_r.size() / kPatches));
    const Vector3 out = direction(k);
    const std::optional<Place> middle = touch(view, leaf.p + leaf.r * out, out);
    const std::optional<SurfaceRipple> ripple =
        middle ? ripple_of(view, *middle) : std::optional<SurfaceRipple>{};
    if (!ripple) continue;
    heights.push_back(ripple->height);
    angles.push_back(ripple->angle);
  }
  if (heights.empty()) return {};
  return {median(heights), median(angles), static_cast<int>(heights.size())};
}

}  // namespace hapticd
