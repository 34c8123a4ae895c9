// See ball_cover.h.
#include "server/model/packing/ball_cover.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "core/math/elementary.h"
#include "server/model/packing/inner_ball.h"
#include "server/model/packing/parallel_chunks.h"

namespace hapticd {
namespace {

/// Candidates per disc of surface that one ball covers. Normal value 8; fewer makes more balls,
/// more takes longer.
constexpr double kCandidatesPerDisc = 8.0;
/// Slacks of the candidates at a patch, as shares of the bound: the smaller ones leave more to
/// spare around, the larger make larger balls.
constexpr double kSlacks[] = {0.3, 0.85};
/// Halvings that make a candidate larger.
constexpr int kRefine = 4;
/// Candidates per chunk of work.
constexpr std::int64_t kChunk = 256;

Vector3 centroid(const Patch& patch) { return (patch.a + patch.b + patch.c) / 3.0; }

/// The ball at the patch's centroid, with the depth of its centre for radius.
Sphere candidate_at(const Patch& patch, const MeshDistance& distance, double slack, double extent) {
  const Sphere ball = inner_ball(distance, centroid(patch), patch.normal, {slack, extent, kRefine});
  return {ball.p, -distance.signed_distance(ball.p)};
}

/// Area not yet covered, by patch and by node.
class Remaining {
 public:
  explicit Remaining(const SurfacePatches& surface) : surface_(surface) {
    for (const Patch& patch : surface.patches) {
      points_.push_back(centroid(patch));
      left_.push_back(patch.area);
    }
    sums_.resize(surface.nodes.size());
    for (std::size_t n = surface.nodes.size(); n-- > 0;) sums_[n] = sum(n);
  }

  /// Uncovered area inside the ball.
  [[nodiscard]] double gain(const Sphere& ball) const { return gain(ball, 0); }
  /// Covers all inside the ball.
  void cover(const Sphere& ball) { cover(ball, 0, false); }
  [[nodiscard]] bool is_left(std::size_t patch) const { return left_[patch] > 0.0; }

 private:
  enum class Overlap { kNone, kPart, kAll };

  Overlap overlap(const PatchNode& node, const Sphere& ball) const {
    const Vector3 out = (node.low - ball.p).cwiseMax(ball.p - node.high).cwiseMax(0.0);
    const double squared = ball.r * ball.r;
    if (out.squaredNorm() > squared) return Overlap::kNone;
    const Vector3 far = (node.low - ball.p).cwiseAbs().cwiseMax((node.high - ball.p).cwiseAbs());
    return far.squaredNorm() <= squared ? Overlap::kAll : Overlap::kPart;
  }

  double sum(std::size_t n) const {
    const PatchNode& node = surface_.nodes[n];
    if (node.child != 0) {
      return sums_[static_cast<std::size_t>(node.child)] +
             sums_[static_cast<std::size_t>(node.child) + 1];
    }
    double total = 0.0;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      total += left_[static_cast<std::size_t>(i)];
    }
    return total;
  }

  // NOLINTNEXTLINE(misc-no-recursion): as deep as the tree, which is halved by count
  double gain(const Sphere& ball, std::size_t n) const {
    if (!(sums_[n] > 0.0)) return 0.0;
    const PatchNode& node = surface_.nodes[n];
    const Overlap how = overlap(node, ball);
    if (how == Overlap::kNone) return 0.0;
    if (how == Overlap::kAll) return sums_[n];
    if (node.child != 0) {
      const auto child = static_cast<std::size_t>(node.child);
      return gain(ball, child) + gain(ball, child + 1);
    }
    double total = 0.0;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if ((points_[k] - ball.p).squaredNorm() <= ball.r * ball.r) total += left_[k];
    }
    return total;
  }

  // NOLINTNEXTLINE(misc-no-recursion): as deep as the tree, which is halved by count
  void cover(const Sphere& ball, std::size_t n, bool all) {
    if (!(sums_[n] > 0.0)) return;
    const PatchNode& node = surface_.nodes[n];
    if (!all) {
      const Overlap how = overlap(node, ball);
      if (how == Overlap::kNone) return;
      all = how == Overlap::kAll;
    }
    if (node.child != 0) {
      const auto child = static_cast<std::size_t>(node.child);
      cover(ball, child, all);
      cover(ball, child + 1, all);
    } else {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (all || (points_[k] - ball.p).squaredNorm() <= ball.r * ball.r) left_[k] = 0.0;
      }
    }
    sums_[n] = sum(n);
  }

  const SurfacePatches& surface_;
  std::vector<Vector3> points_;
  std::vector<double> left_;
  std::vector<double> sums_;
};

/// Patches to place candidates at: evenly by discs, in the order of the tree.
std::vector<std::int32_t> draw(const SurfacePatches& surface) {
  std::vector<std::int32_t> drawn;
  double carried = 0.5;
  for (std::size_t i = 0; i < surface.patches.size(); ++i) {
    const Patch& patch = surface.patches[i];
    carried += kCandidatesPerDisc * patch.area / (kPi * patch.reach * patch.reach);
    if (carried < 1.0) continue;
    drawn.push_back(static_cast<std::int32_t>(i));
    carried = std::min(carried - 1.0, 1.0);
  }
  return drawn;
}

struct Offer {
  double gain;
  std::int32_t candidate;
  bool operator<(const Offer& other) const {
    return gain != other.gain ? gain < other.gain : candidate > other.candidate;
  }
};

}  // namespace

std::vector<Sphere> cover_greedily(const SurfacePatches& surface, const MeshDistance& distance,
                                   double bound, double extent, int threads) {
  const std::vector<std::int32_t> drawn = draw(surface);
  constexpr std::size_t kKinds = std::size(kSlacks);
  Remaining remaining(surface);
  std::vector<Sphere> candidates(drawn.size() * kKinds);
  std::vector<Offer> offers(candidates.size());
  for_chunks(static_cast<std::int64_t>(candidates.size()), kChunk, threads,
             [&](std::int64_t, std::int64_t begin, std::int64_t end) {
               for (std::int64_t i = begin; i < end; ++i) {
                 const auto k = static_cast<std::size_t>(i);
                 const Patch& patch = surface.patches[static_cast<std::size_t>(drawn[k / kKinds])];
                 candidates[k] = candidate_at(patch, distance, kSlacks[k % kKinds] * bound, extent);
                 offers[k] = {remaining.gain({candidates[k].p, candidates[k].r + bound}),
                              static_cast<std::int32_t>(i)};
               }
             });
  std::vector<Sphere> balls;
  std::priority_queue<Offer> queue({}, std::move(offers));
  while (!queue.empty()) {
    Offer best = queue.top();
    queue.pop();
    const Sphere& candidate = candidates[static_cast<std::size_t>(best.candidate)];
    const Sphere grown{candidate.p, candidate.r + bound};
    best.gain = remaining.gain(grown);
    if (!(best.gain > 0.0)) continue;
    if (!queue.empty() && best < queue.top()) {
      queue.push(best);
      continue;
    }
    remaining.cover(grown);
    balls.push_back(candidate);
  }
  for (std::size_t i = 0; i < surface.patches.size(); ++i) {
    if (!remaining.is_left(i)) continue;
    const Sphere ball = candidate_at(surface.patches[i], distance, 0.5 * bound, extent);
    remaining.cover({ball.p, ball.r + bound});
    balls.push_back(ball);
  }
  return balls;
}

}  // namespace hapticd
