// See sphere_packing.h.
#include "core/modeling/sphere_packing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/geometry/closest_point.h"
#include "core/modeling/ball_cover.h"
#include "core/modeling/inner_ball.h"
#include "core/modeling/packing_refinement.h"

namespace hapticd {
namespace {

/// Most spheres of a tree.
constexpr double kMostSpheres = 16777216.0;
/// Rounding margin of radii, as a share of the extent of the mesh. Normal value 1e-14 (coordinates
/// are rounded to 1e-16 of it, distances to a few times that).
constexpr double kMargin = 1e-14;

struct Task {
  const TriangleMesh& mesh;
  const MeshDistance& distance;
  const PackingOptions& options;
  double extent;
};

void check(const PackingOptions& options) {
  const auto refuse = [](const char* what) {
    throw std::invalid_argument(std::string("sphere packing: ") + what);
  };
  if (options.leaves ? *options.leaves < 1 : !(options.outer > 0.0 && options.outer < 1e70)) {
    refuse(options.leaves ? "at least one leaf is needed" : "the bound must be positive");
  }
  if (options.leaves && *options.leaves > static_cast<int>(kMostSpheres)) {
    refuse("a tree has at most 16777216 leaves");
  }
  if (!(options.inner >= 0.0 && options.inner < 1e70)) refuse("inner must not be negative");
  if (options.threads < 1) refuse("at least one thread is needed");
}

void report(const Task& task, double done) {
  if (task.options.progress) task.options.progress(done);
}

/// Removes the balls marked, and those without points.
void keep_only(const std::vector<bool>& keep, BallSet& set) {
  std::vector<Sphere> kept;
  for (std::size_t k = 0; k < set.balls.size(); ++k) {
    if (keep[k]) kept.push_back(set.balls[k]);
  }
  set.balls = std::move(kept);
}

/// Marks `count` balls to go, cheapest first, no two close together.
std::size_t drop_cheapest(std::size_t count, double limit, BallSet& set) {
  std::vector<std::size_t> order;
  std::vector<bool> keep(set.balls.size(), true);
  for (std::size_t k = 0; k < set.balls.size(); ++k) {
    if (set.first[k] == set.first[k + 1]) {
      keep[k] = false;
    } else if (set.growth_without[k] <= limit) {
      order.push_back(k);
    }
  }
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    const double gi = set.growth_without[i];
    const double gj = set.growth_without[j];
    return gi != gj ? gi < gj : i < j;
  });
  std::vector<std::size_t> gone;
  for (const std::size_t k : order) {
    if (gone.size() >= count) break;
    const Sphere& ball = set.balls[k];
    const auto reach = [&](std::size_t i) {
      const double r = std::max(set.balls[i].r, 0.0);
      const double g = std::max(set.growth[i], 0.0);
      return std::sqrt(2.0 * r * g) + g;
    };
    const bool near = std::any_of(gone.begin(), gone.end(), [&](std::size_t j) {
      return length(set.balls[j].p - ball.p) < 1.5 * (reach(j) + reach(k));
    });
    if (near) continue;
    gone.push_back(k);
    keep[k] = false;
  }
  keep_only(keep, set);
  return gone.size();
}

/// New balls at the farthest points of the `count` balls of largest growth above `limit`.
std::size_t add_at_worst(const Task& task, std::size_t count, double limit, BallSet& set) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < set.balls.size(); ++k) {
    if (set.growth[k] > limit) order.push_back(k);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return set.growth[i] != set.growth[j] ? set.growth[i] > set.growth[j] : i < j;
  });
  if (order.size() > count) order.resize(count);
  for (const std::size_t k : order) {
    const Sphere ball = set.balls[k];
    const auto begin = set.points.begin() + set.first[k];
    const auto end = set.points.begin() + set.first[k + 1];
    const auto far = std::max_element(begin, end, [&](const Vector3& p, const Vector3& q) {
      return (p - ball.p).squaredNorm() < (q - ball.p).squaredNorm();
    });
    const NearestPoint nearest = task.distance.nearest(*far);
    const Triangle& t = task.mesh.triangles[static_cast<std::size_t>(nearest.triangle)];
    const Vector3& a = task.mesh.vertices[static_cast<std::size_t>(t[0])];
    const Vector3& b = task.mesh.vertices[static_cast<std::size_t>(t[1])];
    const Vector3& c = task.mesh.vertices[static_cast<std::size_t>(t[2])];
    const Vector3 across = (b - a).cross(c - a);
    const double twice = length(across);
    if (!(twice > 0.0)) continue;
    const Sphere fresh =
        inner_ball(task.distance, *far, across / twice, 0.5 * limit, task.extent, 4);
    set.balls.push_back({fresh.p, -task.distance.signed_distance(fresh.p)});
  }
  return order.size();
}

/// Assignment and moves, `times` times.
void settle(const Task& task, const SurfacePatches& surface, double scale, int times,
            BallSet& set) {
  for (int i = 0; i < times; ++i) {
    assign_pieces(surface, {scale, 3, task.options.threads}, set);
    move_balls(task.distance, 20, task.options.threads, set);
  }
}

/// Covers with all growths at most `bound`.
BallSet pack_to_bound(const Task& task, const SurfacePatches& surface, double bound) {
  BallSet set;
  set.balls = cover_greedily(surface, task.distance, bound, task.extent, task.options.threads);
  report(task, 0.2);
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds; ++round) {
    settle(task, surface, bound, 2, set);
    assign_pieces(surface, {bound, 3, task.options.threads}, set);
    drop_cheapest(set.balls.size() / 10 + 1, 1.25 * bound, set);
    report(task, 0.2 + 0.7 * (round + 1) / kRounds);
  }
  for (int round = 0; round < 200; ++round) {
    settle(task, surface, bound, 1, set);
    if (largest_growth(set) <= bound) break;
    settle(task, surface, bound, 1, set);
    if (add_at_worst(task, set.balls.size(), bound, set) == 0) break;
  }
  assign_pieces(surface, {bound, 3, task.options.threads}, set);
  return set;
}

/// At most `count` balls with small growth.
BallSet pack_to_count(const Task& task, std::size_t count) {
  // The number of balls goes about as 1 / bound: search the bound whose greedy cover fits.
  double bound = 0.01 * task.extent;
  BallSet set;
  SurfacePatches surface;
  double best = 0.0;
  for (int i = 0; i < 6; ++i) {
    surface = divide_surface(task.mesh, task.distance, {bound, 0.25, task.options.threads});
    set.balls = cover_greedily(surface, task.distance, bound, task.extent, task.options.threads);
    const double ratio = static_cast<double>(set.balls.size()) / static_cast<double>(count);
    if (ratio > 0.95 && ratio < 1.1) break;
    bound *= ratio;
  }
  BallSet kept;
  const int rounds = std::clamp(6000 / static_cast<int>(count), 8, 100);
  for (int round = 0; round < rounds; ++round) {
    settle(task, surface, bound, 2, set);
    assign_pieces(surface, {bound, 3, task.options.threads}, set);
    const std::size_t extra = set.balls.size() > count ? set.balls.size() - count : 0;
    if (extra == 0) {
      const double now = largest_growth(set);
      if (kept.balls.empty() || now < best) {
        best = now;
        kept = set;
      }
      const std::size_t swaps = 1 + count / 10 * static_cast<std::size_t>(rounds - round) /
                                        static_cast<std::size_t>(rounds);
      std::vector<double> sorted = set.growth;
      std::sort(sorted.begin(), sorted.end());
      add_at_worst(task, swaps, sorted[sorted.size() / 2], set);
      settle(task, surface, bound, 2, set);
      assign_pieces(surface, {bound, 3, task.options.threads}, set);
    }
    if (set.balls.size() > count) drop_cheapest(set.balls.size() - count, 1e300, set);
    report(task, 0.1 + 0.9 * (round + 1) / rounds);
  }
  return kept;
}

}  // namespace

Packing pack_spheres(const TriangleMesh& mesh, const MeshDistance& distance,
                     const PackingOptions& options) {
  check(options);
  const Task task{mesh, distance, options, mesh_extent(mesh)};
  BallSet set;
  report(task, 0.0);
  if (options.leaves) {
    set = pack_to_count(task, static_cast<std::size_t>(*options.leaves));
  } else {
    const double bound = options.outer + options.inner;
    if (estimated_balls(mesh, distance, bound) > kMostSpheres) {
      throw std::runtime_error("sphere packing: the bound would take more than 16777216 spheres");
    }
    const SurfacePatches surface = divide_surface(mesh, distance, {bound, 0.25, options.threads});
    set = pack_to_bound(task, surface, bound);
  }
  Packing packing;
  packing.inner = options.inner;
  const double margin = kMargin * task.extent;
  for (std::size_t k = 0; k < set.balls.size(); ++k) {
    if (set.first[k] == set.first[k + 1]) continue;
    const Sphere& ball = set.balls[k];
    double squared = 0.0;
    for (std::int64_t i = set.first[k]; i < set.first[k + 1]; ++i) {
      squared = std::max(squared, (set.points[static_cast<std::size_t>(i)] - ball.p).squaredNorm());
    }
    const double r = std::max(std::sqrt(squared) - options.inner + margin, 0.0);
    packing.leaves.push_back({ball.p, r});
    packing.outer = std::max(packing.outer, r - ball.r + margin);
  }
  report(task, 1.0);
  return packing;
}

}  // namespace hapticd
