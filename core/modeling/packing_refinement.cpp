// See packing_refinement.h.
#include "core/modeling/packing_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"
#include "core/modeling/counter_random.h"
#include "core/modeling/parallel_chunks.h"
#include "core/modeling/sphere_index.h"

namespace hapticd {
namespace {

/// A piece is cut where the corners' balls might save this share of the scale. Normal value 0.02;
/// smaller makes more pieces for a growth that does not show.
constexpr double kWorthCutting = 0.02;
/// Leaves of the tree of patches, and balls, per chunk of work.
constexpr std::int64_t kLeafChunk = 64;
constexpr std::int64_t kBallChunk = 8;
/// First step of a move as a share of the radius of the disc a ball covers, and how often it may be
/// halved in one call.
constexpr double kFirstStep = 0.25;
constexpr int kHalvings = 7;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Piece {
  Vector3 a, b, c;
};

/// A piece with the ball it goes to.
struct Assigned {
  std::int32_t ball;
  double growth;
  double growth_without;
  Piece piece;
};

/// Assigns the patches of one leaf.
class LeafAssigner {
 public:
  LeafAssigner(const std::vector<Sphere>& balls, const AssignOptions& options,
               std::vector<Assigned>& found)
      : balls_(balls), options_(options), found_(found) {}

  std::vector<std::int32_t> near;  ///< balls to choose from

  void assign(const Piece& piece, int depth) {
    // Smallest growth by corner, and smallest by ball for all three corners.
    std::array<double, 3> least{kInfinity, kInfinity, kInfinity};
    Assigned best{-1, kInfinity, kInfinity, piece};
    for (const std::int32_t k : near) {
      const Sphere& ball = balls_[static_cast<std::size_t>(k)];
      const std::array<double, 3> gap{length(piece.a - ball.p) - ball.r,
                                      length(piece.b - ball.p) - ball.r,
                                      length(piece.c - ball.p) - ball.r};
      const double growth = std::max(gap[0], std::max(gap[1], gap[2]));
      for (std::size_t i = 0; i < 3; ++i) least[i] = std::min(least[i], gap[i]);
      if (growth < best.growth) {
        best.growth_without = best.growth;
        best.growth = growth;
        best.ball = k;
      } else if (growth < best.growth_without) {
        best.growth_without = growth;
      }
    }
    const double bound = std::max(least[0], std::max(least[1], least[2]));
    if (depth >= options_.cuts || best.growth - bound <= kWorthCutting * options_.scale) {
      found_.push_back(best);
      return;
    }
    const Vector3 ab = 0.5 * (piece.a + piece.b);
    const Vector3 bc = 0.5 * (piece.b + piece.c);
    const Vector3 ca = 0.5 * (piece.c + piece.a);
    assign({piece.a, ab, ca}, depth + 1);
    assign({ab, piece.b, bc}, depth + 1);
    assign({ca, bc, piece.c}, depth + 1);
    assign({ab, bc, ca}, depth + 1);
  }

 private:
  const std::vector<Sphere>& balls_;
  const AssignOptions& options_;
  std::vector<Assigned>& found_;
};

double growth_at(const Vector3& p, double depth, const Vector3* begin, const Vector3* end) {
  double squared = 0.0;
  for (const Vector3* i = begin; i != end; ++i) {
    squared = std::max(squared, (*i - p).squaredNorm());
  }
  return std::sqrt(squared) - depth;
}

/// Search for the centre that needs the least growth, by trial steps along the directions that can
/// help: towards the farthest point (also tangentially), away from the nearest surface, at random.
class Mover {
 public:
  Mover(const MeshDistance& distance, const Vector3* begin, const Vector3* end, std::uint64_t seed)
      : distance_(distance), begin_(begin), end_(end), seed_(seed) {}

  double growth = 0.0;

  void run(Sphere& ball, int rounds) {
    growth = growth_at(ball.p, ball.r, begin_, end_);
    look(ball.p);
    const double reach = std::sqrt(std::max(2.0 * std::max(ball.r, 0.0) * growth, 0.0)) + growth;
    double step = kFirstStep * reach;
    int halved = 0;
    for (int round = 0; round < rounds && halved < kHalvings; ++round) {
      if (try_all(ball, step)) continue;
      step *= 0.5;
      ++halved;
    }
  }

 private:
  static constexpr int kDirections = 8;

  void look(const Vector3& p) {
    double squared = -1.0;
    for (const Vector3* i = begin_; i != end_; ++i) {
      const double now = (*i - p).squaredNorm();
      if (now > squared) {
        squared = now;
        farthest_ = *i;
      }
    }
    NearestPoint nearest;
    const double d = distance_.signed_distance(p, nearest);
    const Vector3 away = d < 0.0 ? Vector3(p - nearest.p) : Vector3(nearest.p - p);
    const double size = length(away);
    away_ = size > 0.0 ? Vector3(away / size) : Vector3(0.0, 0.0, 0.0);
    const Vector3 to = farthest_ - p;
    const double far = length(to);
    to_ = far > 0.0 ? Vector3(to / far) : Vector3(0.0, 0.0, 0.0);
  }

  Vector3 direction(int i) {
    const Vector3 tangential = to_ - to_.dot(away_) * away_;
    const double size = length(tangential);
    Vector3 d(0.0, 0.0, 0.0);
    switch (i) {
      case 0:
        return size > 0.0 ? Vector3(tangential / size) : to_;
      case 1:
        return to_;
      case 2:
        return away_;
      case 3:
        return -away_;
      default:
        d = counter_direction(seed_, counter_++);
        // Half of the sphere of directions makes it worse: the farthest point gets farther.
        return d.dot(to_) < 0.0 ? Vector3(-d) : d;
    }
  }

  bool try_all(Sphere& ball, double step) {
    bool better = false;
    for (int i = 0; i < kDirections; ++i) {
      const Vector3 p = ball.p + step * direction(i);
      const double depth = -distance_.signed_distance(p);
      const double now = growth_at(p, depth, begin_, end_);
      if (!(now < growth)) continue;
      ball = {p, depth};
      growth = now;
      look(p);
      better = true;
    }
    return better;
  }

  const MeshDistance& distance_;
  const Vector3* begin_;
  const Vector3* end_;
  std::uint64_t seed_;
  std::uint64_t counter_ = 0;
  Vector3 farthest_{0.0, 0.0, 0.0};
  Vector3 away_{0.0, 0.0, 0.0};
  Vector3 to_{0.0, 0.0, 0.0};
};

}  // namespace

void assign_pieces(const SurfacePatches& surface, const AssignOptions& options, BallSet& set) {
  const SphereIndex index(set.balls);
  const auto leaves = static_cast<std::int64_t>(surface.leaves.size());
  std::vector<std::vector<Assigned>> found(
      static_cast<std::size_t>(chunk_count(leaves, kLeafChunk)));
  for_chunks(
      leaves, kLeafChunk, options.threads,
      [&](std::int64_t chunk, std::int64_t begin, std::int64_t end) {
        LeafAssigner assigner(set.balls, options, found[static_cast<std::size_t>(chunk)]);
        for (std::int64_t i = begin; i < end; ++i) {
          const PatchNode& node =
              surface.nodes[static_cast<std::size_t>(surface.leaves[static_cast<std::size_t>(i)])];
          const Vector3 middle = 0.5 * (node.low + node.high);
          const double radius = 0.5 * length(node.high - node.low);
          // Every ball that can be best somewhere in the leaf, and those that could take
          // over for little more.
          assigner.near.clear();
          index.within(middle, index.nearest(middle).gap + 2.0 * radius + options.scale,
                       assigner.near);
          for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
            const Patch& patch = surface.patches[static_cast<std::size_t>(k)];
            assigner.assign({patch.a, patch.b, patch.c}, 0);
          }
        }
      });
  const std::size_t count = set.balls.size();
  set.first.assign(count + 1, 0);
  set.growth.assign(count, -kInfinity);
  set.growth_without.assign(count, -kInfinity);
  for (const std::vector<Assigned>& part : found) {
    for (const Assigned& piece : part) {
      const auto k = static_cast<std::size_t>(piece.ball);
      set.first[k + 1] += 3;
      set.growth[k] = std::max(set.growth[k], piece.growth);
      set.growth_without[k] = std::max(set.growth_without[k], piece.growth_without);
    }
  }
  for (std::size_t k = 0; k < count; ++k) set.first[k + 1] += set.first[k];
  std::vector<std::int64_t> at(set.first.begin(), set.first.end() - 1);
  set.points.resize(static_cast<std::size_t>(set.first.back()));
  for (const std::vector<Assigned>& part : found) {
    for (const Assigned& piece : part) {
      std::int64_t& next = at[static_cast<std::size_t>(piece.ball)];
      for (const Vector3* p : {&piece.piece.a, &piece.piece.b, &piece.piece.c}) {
        set.points[static_cast<std::size_t>(next++)] = *p;
      }
    }
  }
}

void move_balls(const MeshDistance& distance, int rounds, int threads, BallSet& set) {
  for_chunks(static_cast<std::int64_t>(set.balls.size()), kBallChunk, threads,
             [&](std::int64_t, std::int64_t begin, std::int64_t end) {
               for (std::int64_t i = begin; i < end; ++i) {
                 const auto k = static_cast<std::size_t>(i);
                 if (set.first[k] == set.first[k + 1]) continue;
                 Mover mover(distance, set.points.data() + set.first[k],
                             set.points.data() + set.first[k + 1], static_cast<std::uint64_t>(i));
                 mover.run(set.balls[k], rounds);
                 set.growth[k] = mover.growth;
               }
             });
}

double largest_growth(const BallSet& set) {
  double largest = -kInfinity;
  for (const double growth : set.growth) largest = std::max(largest, growth);
  return largest;
}

}  // namespace hapticd
