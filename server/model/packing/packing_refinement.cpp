// See packing_refinement.h.
#include "server/model/packing/packing_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/closest_point.h"
#include "server/model/packing/parallel_chunks.h"
#include "server/model/packing/sphere_index.h"

namespace hapticd {
namespace {

/// A piece is cut where the corners' balls might save this share of the scale. Normal value 0.02;
/// smaller makes more pieces for a growth that does not show.
constexpr double kWorthCutting = 0.02;
/// Nor are pieces cut that need less than this share of the scale. Normal value 0.4; smaller cuts
/// pieces well inside the disc of their ball.
constexpr double kSmallGrowth = 0.4;
/// Share of the scale by which a ball may be worse than the best at all corners of a piece and
/// still be offered its parts. Normal value 0.1; smaller may miss the best ball of a part.
constexpr double kNearlyBest = 0.1;
/// Leaves of the tree of patches per chunk of work.
constexpr std::int64_t kLeafChunk = 64;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Piece {
  Vector3 a, b, c;
};

/// A piece with the ball it goes to.
struct Assigned {
  std::int32_t ball;
  double growth;
  double growth_without;
  Vector3 farthest;  ///< corner that decides the growth
};

/// Assigns the patches of one leaf.
class LeafAssigner {
 public:
  LeafAssigner(const std::vector<Sphere>& balls, const AssignOptions& options,
               std::vector<Assigned>& found)
      : balls_(balls), options_(options), found_(found) {}

  /// Finds every ball that can be best somewhere in the node, and those that could take over for
  /// little more.
  void look_near(const PatchNode& node, const SphereIndex& index) {
    const Vector3 middle = 0.5 * (node.low + node.high);
    const double radius = 0.5 * length(node.high - node.low);
    near_.clear();
    index.within(middle, index.nearest(middle).gap + 2.0 * radius + options_.scale, near_);
    // The same with the distances to the box instead of its middle: seen from afar it is thin.
    double upper = kInfinity;
    for (const std::int32_t k : near_) {
      const Sphere& ball = balls_[static_cast<std::size_t>(k)];
      const Vector3 far = (node.low - ball.p).cwiseAbs().cwiseMax((node.high - ball.p).cwiseAbs());
      upper = std::min(upper, length(far) - ball.r);
    }
    std::erase_if(near_, [&](std::int32_t k) {
      const Sphere& ball = balls_[static_cast<std::size_t>(k)];
      const Vector3 out = (node.low - ball.p).cwiseMax(ball.p - node.high).cwiseMax(0.0);
      return length(out) - ball.r > upper + options_.scale;
    });
    nearest_.resize(near_.size());
  }

  void assign(const Piece& piece) { assign(piece, near_.size(), 0); }

 private:
  /// Chooses among the first `count` balls of near_, which may change places.
  // NOLINTNEXTLINE(misc-no-recursion): as deep as options_.cuts
  void assign(const Piece& piece, std::size_t count, int depth) {
    // Smallest growth by corner, and smallest by ball for all three corners.
    std::array<double, 3> least{kInfinity, kInfinity, kInfinity};
    Assigned best{-1, kInfinity, kInfinity, piece.a};
    for (std::size_t j = 0; j < count; ++j) {
      const std::int32_t k = near_[j];
      const Sphere& ball = balls_[static_cast<std::size_t>(k)];
      const std::array<double, 3> gap{length(piece.a - ball.p) - ball.r,
                                      length(piece.b - ball.p) - ball.r,
                                      length(piece.c - ball.p) - ball.r};
      const double growth = std::max(gap[0], std::max(gap[1], gap[2]));
      for (std::size_t i = 0; i < 3; ++i) least[i] = std::min(least[i], gap[i]);
      nearest_[j] = std::min(gap[0], std::min(gap[1], gap[2]));
      if (growth < best.growth || (growth == best.growth && k < best.ball)) {
        best.growth_without = best.growth;
        best.growth = growth;
        best.ball = k;
        best.farthest = growth == gap[0] ? piece.a : (growth == gap[1] ? piece.b : piece.c);
      } else {
        best.growth_without = std::min(best.growth_without, growth);
      }
    }
    const double bound = std::max(least[0], std::max(least[1], least[2]));
    if (depth >= options_.cuts || best.growth <= kSmallGrowth * options_.scale ||
        best.growth - bound <= kWorthCutting * options_.scale) {
      found_.push_back(best);
      return;
    }
    // Parts of the piece go to balls that are good at a corner of it.
    std::size_t kept = 0;
    for (std::size_t j = 0; j < count; ++j) {
      if (nearest_[j] > bound + kNearlyBest * options_.scale) continue;
      std::swap(near_[kept], near_[j]);
      std::swap(nearest_[kept], nearest_[j]);
      ++kept;
    }
    const Vector3 ab = 0.5 * (piece.a + piece.b);
    const Vector3 bc = 0.5 * (piece.b + piece.c);
    const Vector3 ca = 0.5 * (piece.c + piece.a);
    assign({piece.a, ab, ca}, kept, depth + 1);
    assign({ab, piece.b, bc}, kept, depth + 1);
    assign({ca, bc, piece.c}, kept, depth + 1);
    assign({ab, bc, ca}, kept, depth + 1);
  }

  const std::vector<Sphere>& balls_;
  const AssignOptions& options_;
  std::vector<Assigned>& found_;
  std::vector<std::int32_t> near_;  ///< balls to choose from
  std::vector<double> nearest_;     ///< their smallest gap at a corner of the piece
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
          assigner.look_near(node, index);
          for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
            const Patch& patch = surface.patches[static_cast<std::size_t>(k)];
            assigner.assign({patch.a, patch.b, patch.c});
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
      ++set.first[k + 1];
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
      set.points[static_cast<std::size_t>(next++)] = piece.farthest;
    }
  }
}

double largest_growth(const BallSet& set) {
  double largest = -kInfinity;
  for (const double growth : set.growth) largest = std::max(largest, growth);
  return largest;
}

}  // namespace hapticd
