// See sphere_packing.h.
#include "server/model/packing/sphere_packing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/geometry/closest_point.h"
#include "server/model/packing/ball_cover.h"
#include "server/model/packing/inner_ball.h"
#include "server/model/packing/packing_refinement.h"

namespace hapticd {
namespace {

/// Most spheres of a tree.
constexpr double kMaxSpheres = 16777216.0;
/// Rounding margin of radii, as a share of the extent of the mesh. Normal value 1e-14 (coordinates
/// are rounded to 1e-16 of it, distances to a few times that).
constexpr double kMargin = 1e-14;
/// Longest side of a patch as a share of the reach of a ball, and how often it is halved where
/// balls meet. Normal values 0.4 and 3; finer takes longer for less than 2 % of the bound.
constexpr double kPatchSize = 0.4;
constexpr int kCuts = 3;
/// Trials of one move of a ball. Normal value 24.
constexpr int kTrials = 24;
/// Rounds of dropping balls under a given bound, the share of balls dropped in each, and the growth
/// (as a share of the bound) up to which the others may take over: they move afterwards. Larger
/// shares drop balls that have to come back.
constexpr int kDropRounds = 8;
constexpr std::size_t kDropShare = 10;
constexpr double kTakeOver = 1.3;
/// Share of balls added in each round while the bound is not met, and most rounds of that.
constexpr std::size_t kAddShare = 16;
constexpr int kAddRounds = 400;
/// Greedy covers made to find the bound of a number of balls, and the share by which it may miss.
constexpr int kSearchRounds = 7;
constexpr double kSearchLow = 0.95;
constexpr double kSearchHigh = 1.1;
/// A bound that takes this many patches per wanted ball (and this many at all) is not made smaller:
/// the mesh is its own limit, as that of a divided sphere.
constexpr std::size_t kPatchesPerBall = 3000;
constexpr std::size_t kPatchesAtLeast = 300'000;
/// Balls moved about to make a number of balls better: rounds times balls, within limits.
constexpr int kSwapWork = 6000;
constexpr int kMinSwapRounds = 8;
constexpr int kMaxSwapRounds = 80;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

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
  if (options.leaves && *options.leaves > static_cast<int>(kMaxSpheres)) {
    refuse("a tree has at most 16777216 leaves");
  }
  if (!(options.inner >= 0.0 && options.inner < 1e70)) refuse("inner must not be negative");
  if (options.threads < 1) refuse("at least one thread is needed");
}

void report(const Task& task, double done) {
  if (task.options.progress) task.options.progress(done);
}

/// Leaves only the marked balls.
void keep_only(const std::vector<bool>& keep, BallSet& set) {
  std::vector<Sphere> kept;
  for (std::size_t k = 0; k < set.balls.size(); ++k) {
    if (keep[k]) kept.push_back(set.balls[k]);
  }
  set.balls = std::move(kept);
}

/// Drops all balls without pieces and, up to `count` in all, those whose pieces others can take
/// over with growth up to `limit`, cheapest first, no two close together.
void drop_cheapest(std::size_t count, double limit, BallSet& set) {
  std::vector<std::size_t> order;
  std::vector<bool> keep(set.balls.size(), true);
  for (std::size_t k = 0; k < set.balls.size(); ++k) {
    if (set.first[k] == set.first[k + 1]) {
      keep[k] = false;
      count -= std::min<std::size_t>(count, 1);
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
}

/// New balls at the farthest points of up to `count` balls, those of largest growth above `limit`.
void add_at_worst(const Task& task, std::size_t count, double limit, BallSet& set) {
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
    const auto [a, b, c] =
        corners(task.mesh, task.mesh.triangles[static_cast<std::size_t>(nearest.triangle)]);
    const Vector3 across = (b - a).cross(c - a);
    const double twice = length(across);
    if (!(twice > 0.0)) continue;
    const Sphere fresh =
        inner_ball(task.distance, *far, across / twice, {0.5 * limit, task.extent, 4});
    set.balls.push_back({fresh.p, -task.distance.signed_distance(fresh.p)});
  }
}

/// Assignment and moves, `times` times.
void settle(const Task& task, const SurfacePatches& surface, double scale, int times,
            BallSet& set) {
  for (int i = 0; i < times; ++i) {
    assign_pieces(surface, {scale, kCuts, task.options.threads}, set);
    move_balls(task.distance, kTrials, scale, task.options.threads, set);
  }
}

/// Covers with all growths at most `bound`.
BallSet pack_to_bound(const Task& task, const SurfacePatches& surface, double bound) {
  BallSet set;
  set.balls = cover_greedily(surface, task.distance, bound, task.extent, task.options.threads);
  report(task, 0.2);
  for (int round = 0; round < kDropRounds; ++round) {
    settle(task, surface, bound, 2, set);
    drop_cheapest(set.balls.size() / kDropShare + 1, kTakeOver * bound, set);
    report(task, 0.2 + 0.7 * (round + 1) / kDropRounds);
  }
  for (int round = 0; round < kAddRounds; ++round) {
    settle(task, surface, bound, 2, set);
    assign_pieces(surface, {bound, kCuts, task.options.threads}, set);
    if (largest_growth(set) <= bound) return set;
    add_at_worst(task, set.balls.size() / kAddShare + 1, bound, set);
  }
  throw std::runtime_error("sphere packing: the bound is not met; try a larger one");
}

/// First balls for a number of them: the number goes about as 1 / bound.
double cover_by_count(const Task& task, std::size_t count, SurfacePatches& surface, BallSet& set) {
  double bound = 0.01 * task.extent;
  double too_small = 0.0;
  double too_large = kInfinity;
  for (int i = 0;; ++i) {
    surface = divide_surface(task.mesh, task.distance, {bound, kPatchSize, task.options.threads});
    set.balls = cover_greedily(surface, task.distance, bound, task.extent, task.options.threads);
    const double ratio = static_cast<double>(set.balls.size()) / static_cast<double>(count);
    const bool fits = ratio >= kSearchLow && ratio <= kSearchHigh;
    const std::size_t limit = std::max(kPatchesPerBall * count, kPatchesAtLeast);
    const bool at_limit = ratio < 1.0 && surface.patches.size() > limit;
    report(task, 0.1 * (i + 1) / (kSearchRounds + 1));
    if (fits || at_limit || i == kSearchRounds) return bound;
    (ratio > 1.0 ? too_small : too_large) = bound;
    bound *= std::clamp(ratio, 0.2, 5.0);
    if (bound <= too_small || bound >= too_large) bound = std::sqrt(too_small * too_large);
  }
}

/// At most `count` balls with small growth: balls are added where the growth is largest and taken
/// away where it costs least, fewer from round to round; the best set met is the result.
BallSet pack_to_count(const Task& task, std::size_t count) {
  BallSet set;
  SurfacePatches surface;
  const double bound = cover_by_count(task, count, surface, set);
  const int rounds =
      std::clamp(kSwapWork / static_cast<int>(count), kMinSwapRounds, kMaxSwapRounds);
  BallSet best;
  for (int round = 0; round < rounds || best.balls.empty(); ++round) {
    settle(task, surface, bound, 2, set);
    assign_pieces(surface, {bound, kCuts, task.options.threads}, set);
    if (set.balls.size() <= count) {
      if (best.balls.empty() || largest_growth(set) < largest_growth(best)) best = set;
      const double left = 1.0 - std::min(static_cast<double>(round) / rounds, 1.0);
      const std::size_t swaps =
          1 + static_cast<std::size_t>(0.1 * left * static_cast<double>(count));
      std::vector<double> sorted = set.growth;
      std::sort(sorted.begin(), sorted.end());
      add_at_worst(task, count - set.balls.size() + swaps,
                   std::max(std::min(sorted[sorted.size() / 2], 0.9 * sorted.back()), 0.1 * bound),
                   set);
      settle(task, surface, bound, 2, set);
      assign_pieces(surface, {bound, kCuts, task.options.threads}, set);
    }
    if (set.balls.size() > count) drop_cheapest(set.balls.size() - count, kInfinity, set);
    report(task, 0.1 + 0.9 * std::min((round + 1.0) / rounds, 1.0));
  }
  return best;
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
    // What rounding and its margins take.
    const double goal = bound - 4.0 * kMargin * task.extent;
    if (!(goal > 0.0)) throw std::runtime_error("sphere packing: the bound is lost in rounding");
    if (estimated_balls(mesh, distance, bound) > kMaxSpheres) {
      throw std::runtime_error("sphere packing: the bound would take more than 16777216 spheres");
    }
    const SurfacePatches surface =
        divide_surface(mesh, distance, {bound, kPatchSize, options.threads});
    set = pack_to_bound(task, surface, goal);
  }
  Packing packing;
  packing.inner = options.inner;
  const double margin = kMargin * task.extent;
  for (std::size_t k = 0; k < set.balls.size(); ++k) {
    if (set.first[k] == set.first[k + 1]) continue;
    const Sphere& ball = set.balls[k];
    const double r = std::max(ball.r + set.growth[k] - options.inner + margin, 0.0);
    packing.leaves.push_back({ball.p, r});
    packing.outer = std::max(packing.outer, r - ball.r + margin);
  }
  report(task, 1.0);
  return packing;
}

}  // namespace hapticd
