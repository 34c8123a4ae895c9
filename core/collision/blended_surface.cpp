// The leaves within reach of the blend, and the equation of phi. See blended_surface.h. RT: yes.
#include "core/collision/blended_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/collision/blend_steepness.h"
#include "core/collision/descent.h"
#include "core/collision/node_kernels.h"
#include "core/collision/obstacles.h"
#include "core/math/cpu.h"

namespace hapticd {
namespace {

/// Steps of Halley's method: four reach the rounding.
constexpr int kMaxSteps = 16;
/// A step below this, in widths, is rounding.
constexpr double kRounding = 1e-15;
/// How far from where leaves are looked for they are used again, as a share of the width. More:
/// more leaves that have no share; less: looked for more often.
constexpr double kAround = 0.25;
/// A coordinate that no point has.
constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();

/// A leaf and how far a point is from it.
struct NearLeaf {
  TreeSphereId id;
  double gap;  ///< m
  Sphere sphere;
};

double gap_of(const Sphere& leaf, const Vector3& p_B) noexcept {
  return length(p_B - leaf.p) - leaf.r;
}

/// The leaves whose gaps are less than `beyond` above the smallest.
struct NearLeaves {
  explicit NearLeaves(double beyond_the_least) noexcept : beyond(beyond_the_least) {}

  double beyond;                                           ///< m
  double least = std::numeric_limits<double>::infinity();  ///< smallest gap, or a bound of it, m
  std::size_t count = 0;
  std::array<NearLeaf, kMaxBlended> leaf;

  [[nodiscard]] double reach() const noexcept { return least + beyond; }

  void add(const NearLeaf& near) noexcept {
    if (!(near.gap < reach())) return;
    least = std::min(least, near.gap);
    if (count == kMaxBlended) drop();
    leaf[count++] = near;
  }

  /// Leaves those within reach alone, in ascending order, so that sums do not depend on the way.
  void finish() noexcept {
    drop_far();
    std::sort(leaf.begin(), leaf.begin() + static_cast<std::ptrdiff_t>(count),
              [](const NearLeaf& a, const NearLeaf& b) { return a.id < b.id; });
  }

 private:
  void drop_far() noexcept {
    const auto all = leaf.begin() + static_cast<std::ptrdiff_t>(count);
    const auto end = std::remove_if(leaf.begin(), all,
                                    [this](const NearLeaf& near) { return !(near.gap < reach()); });
    count = static_cast<std::size_t>(end - leaf.begin());
  }
  /// Drops those that are out of reach by now, or else the farthest.
  void drop() noexcept {
    drop_far();
    if (count < kMaxBlended) return;
    const auto farthest =
        std::max_element(leaf.begin(), leaf.end(),
                         [](const NearLeaf& a, const NearLeaf& b) { return a.gap < b.gap; });
    std::move(farthest + 1, leaf.end(), farthest);
    --count;
  }
};

NearLeaf leaf_beside(const SphereTreeNode& node, std::size_t k, const Vector3& p_B) noexcept {
  const Sphere sphere{{node.x[k], node.y[k], node.z[k]}, node.r[k]};
  return {~node.child[k], gap_of(sphere, p_B), sphere};
}

/// Gap of the leaf where always taking the nearest child ends, m.
template <typename Kernels>
double gap_of_dive(const SphereTreeView& tree, const SphereProbe& probe) noexcept {
  for (std::size_t n = 0;;) {
    const SphereTreeNode& node = tree.nodes[n];
    Lanes lower;
    Kernels::bounds(lanes_of(node), probe, lower);
    const auto k =
        static_cast<std::size_t>(std::min_element(lower.begin(), lower.end()) - lower.begin());
    if ((node.inner >> k & 1U) == 0) return leaf_beside(node, k, probe.p).gap;
    n = static_cast<std::size_t>(node.child[k]);
  }
}

/// False when nothing below the node is certainly within `radius` (m).
bool may_reach(const SphereTreeView& tree, std::int32_t node, const Vector3& p_B,
               double radius) noexcept {
  if (tree.boxes.empty() || !(radius > 0.0)) return true;
  const NodeBox& box = tree.boxes[static_cast<std::size_t>(node)];
  return may_touch({box.lower, box.upper}, {p_B, radius});
}

template <typename Kernels>
void find_leaves(const SphereTreeView& tree, const SphereProbe& probe, NearLeaves& out) noexcept {
  out.least = gap_of_dive<Kernels>(tree, probe);
  DescentStack<std::int32_t, kMaxTreeDepth*(kTreeWidth - 1) + 1> stack;
  stack.push(0);
  while (!stack.empty()) {
    const SphereTreeNode& node = tree.nodes[static_cast<std::size_t>(stack.pop())];
    const unsigned near = Kernels::near(lanes_of(node), probe, out.reach());
    for (unsigned rest = near & ~node.inner; rest != 0; rest &= rest - 1) {
      out.add(leaf_beside(node, static_cast<std::size_t>(std::countr_zero(rest)), probe.p));
    }
    for (unsigned rest = near & node.inner; rest != 0; rest &= rest - 1) {
      const std::int32_t child = node.child[static_cast<std::size_t>(std::countr_zero(rest))];
      if (may_reach(tree, child, probe.p, out.reach() + probe.inflation)) stack.push(child);
    }
  }
}

void find_leaves(const SphereTreeView& tree, const Vector3& p_B, NearLeaves& out) noexcept {
  const SphereProbe probe{p_B, kRelativeSlack * (length(p_B) + reach(tree))};
  if (avx2_available()) {
    find_leaves<Avx2Kernels>(tree, probe, out);
  } else {
    find_leaves<PortableKernels>(tree, probe, out);
  }
  out.finish();
}

/// Leaves in arrays, a whole number of pairs: what is left over repeats the last. Pairs are
/// computed together, the width every x86-64 has, so that all builds give the same bits.
struct Leaves {
  std::size_t count;
  const double* x;
  const double* y;
  const double* z;
  const double* r;
};

template <std::size_t Capacity>
void copy(const NearLeaves& near, LeafLanes<Capacity>& out) noexcept {
  out.count = near.count;
  const std::size_t whole = (near.count + 1) / 2 * 2;
  for (std::size_t k = 0; k < whole; ++k) {
    const NearLeaf& leaf = near.leaf[std::min(k, near.count - 1)];
    out.id[k] = leaf.id;
    out.x[k] = leaf.sphere.p.x();
    out.y[k] = leaf.sphere.p.y();
    out.z[k] = leaf.sphere.p.z();
    out.r[k] = leaf.sphere.r;
  }
}

template <std::size_t Capacity>
Leaves leaves_of(const LeafLanes<Capacity>& lanes) noexcept {
  return {lanes.count, lanes.x.data(), lanes.y.data(), lanes.z.data(), lanes.r.data()};
}

/// Two doubles that are computed together.
using Pair [[gnu::vector_size(16)]] = double;

Pair both(double value) noexcept { return Pair{value, value}; }
Pair load(const double* from) noexcept { return Pair{from[0], from[1]}; }
void store(double* to, Pair pair) noexcept {
  to[0] = pair[0];
  to[1] = pair[1];
}
Pair root(Pair square) noexcept { return Pair{std::sqrt(square[0]), std::sqrt(square[1])}; }
double sum_of(Pair pair) noexcept { return pair[0] + pair[1]; }

/// Two of an array, wherever they are.
Pair gather(const double* from, std::uint32_t low, std::uint32_t high) noexcept {
  return Pair{from[low], from[high]};
}

/// The equation at a point.
class Blend {
 public:
  Blend(const Leaves& leaves, const Vector3& p_B, double width) noexcept
      : leaves_(leaves), p_B_(p_B), width_(width) {
    const double least = find_gaps();
    keep_near(least);
    phi_ = least + width * solve();
  }

  [[nodiscard]] double phi() const noexcept { return phi_; }
  /// Leaves that have a share, in the order of all.
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::size_t leaf(std::size_t k) const noexcept { return chosen_[k]; }
  [[nodiscard]] double share(std::size_t k) const noexcept {
    return share_[k] * share_[k] / squares_;
  }

  [[nodiscard]] BlendedPlace place() noexcept;
  /// Length of the gradient of phi, once place() was asked for.
  [[nodiscard]] double steepness() const noexcept { return steepness_; }

 private:
  /// Returns the smallest.
  double find_gaps() noexcept {
    const Pair x = both(p_B_.x());
    const Pair y = both(p_B_.y());
    const Pair z = both(p_B_.z());
    Pair least = both(std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < leaves_.count; k += 2) {
      const Pair dx = x - load(leaves_.x + k);
      const Pair dy = y - load(leaves_.y + k);
      const Pair dz = z - load(leaves_.z + k);
      const Pair d = root((dx * dx + dy * dy) + dz * dz);
      const Pair gap = d - load(leaves_.r + k);
      store(&distance_[k], d);
      store(&gap_[k], gap);
      least = gap < least ? gap : least;
    }
    return std::min(least[0], least[1]);
  }

  /// Leaves out what has no share, and finds the shares s_i = 1 - (d_i - phi) / w that phi = the
  /// smallest gap would give.
  void keep_near(double least) noexcept {
    const double inverse = 1.0 / width_;
    for (std::size_t k = 0; k < leaves_.count; ++k) {
      const double s = 1.0 - (gap_[k] - least) * inverse;
      chosen_[count_] = static_cast<std::uint32_t>(k);
      start_[count_] = s;
      count_ += s > 0.0 ? 1U : 0U;
    }
    if (count_ % 2 == 0) return;
    chosen_[count_] = chosen_[count_ - 1];
    start_[count_] = 0.0;
  }

  /// The shares, by Halley's method, from the smallest gap down; returns phi less that, in widths.
  double solve() noexcept {
    double below = 0.0;
    for (int i = 0; i < kMaxSteps; ++i) {
      const Pair zero = both(0.0);
      const Pair down = both(below);
      Pair sums = both(0.0);
      Pair squares = both(0.0);
      Pair cubes = both(0.0);
      for (std::size_t k = 0; k < count_; k += 2) {
        const Pair kept = load(&start_[k]) + down;
        const Pair s = kept > zero ? kept : zero;
        const Pair square = s * s;
        store(&share_[k], s);
        sums = sums + s;
        squares = squares + square;
        cubes = cubes + square * s;
      }
      squares_ = sum_of(squares);
      const double excess = sum_of(cubes) - 1.0;
      const double step = excess * squares_ / (3.0 * squares_ * squares_ - excess * sum_of(sums));
      if (!(std::abs(step) > kRounding)) break;
      below -= step;
    }
    return below;
  }

  alignas(16) std::array<double, kMaxBlended + 2> distance_, gap_;
  alignas(16) std::array<double, kMaxBlended + 2> start_, share_;
  std::array<std::uint32_t, kMaxBlended + 2> chosen_;
  Leaves leaves_;
  Vector3 p_B_;
  double width_;
  double phi_ = 0.0;
  double steepness_ = 0.0;
  std::size_t count_ = 0;
  double squares_ = 0.0;  ///< of the shares
};

/// Sums over the leaves: of their normals by what they have in phi, and what makes its second
/// derivative.
struct Moments {
  Pair x, y, z;                 ///< the gradient of phi
  Pair xx, yy, zz, xy, xz, yz;  ///< of the spread of the normals
  Pair bulge;                   ///< the leaves' own curvature
};

BlendedPlace Blend::place() noexcept {
  const double inverse = 1.0 / squares_;
  const Pair part = both(inverse);
  const Pair hollow = both(2.0 * inverse / width_);
  const Pair zero = both(0.0);
  Moments sum{zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
  for (std::size_t k = 0; k < count_; k += 2) {
    const std::uint32_t a = chosen_[k];
    const std::uint32_t b = chosen_[k + 1];
    const Pair d = gather(distance_.data(), a, b);
    const Pair share = load(&share_[k]);
    const Pair over = d >= both(kMinLength) ? both(1.0) / d : zero;
    // Of each leaf its share in phi, over its distance.
    const Pair weight = share * share * part * over;
    const Pair spread = (weight + hollow * share) * (over * over);
    const Pair x = both(p_B_.x()) - gather(leaves_.x, a, b);
    const Pair y = both(p_B_.y()) - gather(leaves_.y, a, b);
    const Pair z = both(p_B_.z()) - gather(leaves_.z, a, b);
    sum.x = sum.x + x * weight;
    sum.y = sum.y + y * weight;
    sum.z = sum.z + z * weight;
    sum.bulge = sum.bulge + weight;
    const Pair sx = spread * x;
    const Pair sy = spread * y;
    sum.xx = sum.xx + sx * x;
    sum.xy = sum.xy + sx * y;
    sum.xz = sum.xz + sx * z;
    sum.yy = sum.yy + sy * y;
    sum.yz = sum.yz + sy * z;
    sum.zz = sum.zz + spread * z * z;
  }
  BlendedPlace place;
  place.distance = phi_;
  const Vector3 gradient{sum_of(sum.x), sum_of(sum.y), sum_of(sum.z)};
  steepness_ = length(gradient);
  if (steepness_ < kMinLength) return place;
  const double upright = 1.0 / steepness_;
  const Vector3 n = gradient * upright;
  place.nhat_B = n;
  // The second derivative across the normal: the leaves' own curvature, less what the spread of
  // their normals rounds off.
  const double xy = sum_of(sum.xy);
  const double xz = sum_of(sum.xz);
  const double yz = sum_of(sum.yz);
  const Matrix3 M{{sum_of(sum.xx), xy, xz}, {xy, sum_of(sum.yy), yz}, {xz, yz, sum_of(sum.zz)}};
  const double bulge = sum_of(sum.bulge);
  const Vector3 m = M * n;
  // P (bulge - M) P with P = 1 - n n^T.
  const Vector3 u = m - (0.5 * (n.dot(m) + bulge)) * n;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double own = i == j ? bulge : 0.0;
      const double value = ((own - M(i, j)) + (n[i] * u[j] + u[i] * n[j])) * upright;
      place.curvature_B(i, j) = value;
      place.curvature_B(j, i) = value;
    }
  }
  return place;
}

/// Whether what is remembered is of the tree.
bool of_tree(const LeavesAround& around, const SphereTreeView& tree) noexcept {
  return around.tree == tree.nodes.data() && around.size == tree.leaf_r.size();
}

/// Whether the leaves that are remembered are all that matter at the point.
bool holds(const LeavesAround& around, const Vector3& p_B) noexcept {
  return (p_B - around.p_B).squaredNorm() <= around.radius * around.radius;
}

/// Looks for the leaves around the point; false when there are too many to be remembered.
bool look_around(const SphereTreeView& tree, const Vector3& p_B, LeavesAround& out) noexcept {
  const double radius = kAround * tree.blend.width;
  // As the point goes by the radius, one gap grows by that, and the smallest shrinks.
  NearLeaves near(tree.blend.width + 2.0 * radius);
  find_leaves(tree, p_B, near);
  if (near.count > LeavesAround::kCapacity) {
    out.tree = nullptr;
    return false;
  }
  if (!of_tree(out, tree)) {
    for (LeavesAround::Found& found : out.found) found.p_B = Vector3::Constant(kNowhere);
  }
  out.tree = tree.nodes.data();
  out.size = tree.leaf_r.size();
  out.p_B = p_B;
  out.radius = 0.999 * radius;
  copy(near, out.leaves);
  return true;
}

void find_all(const SphereTreeView& tree, const Vector3& p_B,
              LeafLanes<kMaxBlended>& out) noexcept {
  NearLeaves near(tree.blend.width);
  find_leaves(tree, p_B, near);
  copy(near, out);
}

BlendedPlace find_place(const SphereTreeView& tree, const Vector3& p_B) noexcept {
  LeafLanes<kMaxBlended> leaves;
  find_all(tree, p_B, leaves);
  return Blend(leaves_of(leaves), p_B, tree.blend.width).place();
}

}  // namespace

void find_shares(const SphereTreeView& tree, const Vector3& p_B, BlendShares& out) noexcept {
  LeafLanes<kMaxBlended> leaves;
  find_all(tree, p_B, leaves);
  const Blend blend(leaves_of(leaves), p_B, tree.blend.width);
  out.distance = blend.phi();
  out.count = blend.count();
  for (std::size_t k = 0; k < blend.count(); ++k) {
    out.share[k] = {leaves.id[blend.leaf(k)], blend.share(k)};
  }
}

BlendedPlace place_beside_blend(const SphereTreeView& tree, const Vector3& p_B,
                                LeavesAround* memory) noexcept {
  if (memory == nullptr) return find_place(tree, p_B);
  const bool known = of_tree(*memory, tree);
  if (known) {
    for (const LeavesAround::Found& found : memory->found) {
      if (p_B == found.p_B) return found.place;
    }
  }
  if (!(known && holds(*memory, p_B)) && !look_around(tree, p_B, *memory)) {
    return find_place(tree, p_B);
  }
  std::swap(memory->found[0], memory->found[1]);
  memory->found[0] = {p_B, Blend(leaves_of(memory->leaves), p_B, tree.blend.width).place()};
  return memory->found[0].place;
}

double steepness_beside_blend(const SphereTreeView& tree, const Vector3& p_B,
                              LeavesAround* memory) noexcept {
  const auto of = [&](const Leaves& leaves) {
    Blend blend(leaves, p_B, tree.blend.width);
    static_cast<void>(blend.place());
    return blend.steepness();
  };
  if (memory != nullptr && of_tree(*memory, tree) && holds(*memory, p_B)) {
    return of(leaves_of(memory->leaves));
  }
  LeafLanes<kMaxBlended> leaves;
  find_all(tree, p_B, leaves);
  return of(leaves_of(leaves));
}

}  // namespace hapticd
