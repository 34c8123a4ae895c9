// See sphere_tree_file.h. The reader trusts no byte: counts are compared with the bytes that are
// there before anything is allocated.
#include "server/scene_io/sphere_tree_file.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/geometry/closest_point.h"

namespace hapticd {
namespace {

/// The line break is damaged by programs that take the file for text.
constexpr std::array<std::uint8_t, 8> kMagic{'H', 'D', 'T', 'R', 'E', 'E', '\r', '\n'};
/// Raised with every change of the layout; other versions are refused. The second has the width of
/// a blend; a tree without one is written as the first.
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kBlendedVersion = 2;
/// Bytes of one leaf: four doubles.
constexpr std::size_t kLeafBytes = 32;
/// Bytes of one entry of the level table.
constexpr std::size_t kLevelBytes = 20;
/// Fewest bytes of a node: its masks and one slot with a leaf.
constexpr std::size_t kMinNodeBytes = 6;
/// Relative rounding of a computed distance plus radius, at most (enclosing_sphere adds twice as
/// much): a bound that is larger by this contains its leaf in exact arithmetic. Smaller could let a
/// leaf stick out by an ulp, larger would refuse what the builder makes.
constexpr double kRoundUp = 1.0 + 6.0 * std::numeric_limits<double>::epsilon();

using Bytes = std::vector<std::uint8_t>;

void put(Bytes& out, std::uint32_t value) {
  for (unsigned k = 0; k < 4; ++k) out.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

void put(Bytes& out, double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  for (unsigned k = 0; k < 8; ++k) out.push_back(static_cast<std::uint8_t>(bits >> (8 * k)));
}

void put(Bytes& out, double x, double y, double z, double r) {
  for (const double value : {x, y, z, r}) put(out, value);
}

void put_node(Bytes& out, const SphereTreeNode& node) {
  out.push_back(static_cast<std::uint8_t>(node.used));
  out.push_back(static_cast<std::uint8_t>(node.inner));
  for (std::size_t k = 0; k < kTreeWidth; ++k) {
    if ((node.used >> k & 1U) == 0) continue;
    if ((node.inner >> k & 1U) != 0) {
      put(out, node.x[k], node.y[k], node.z[k], node.r[k]);
    } else {
      put(out, static_cast<std::uint32_t>(~node.child[k]));
    }
  }
}

/// What the layout cannot express would be lost without a word.
void check_links(const SphereTree& tree) {
  std::int32_t next = 1;
  for (const SphereTreeNode& node : tree.nodes) {
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      const bool inner = (node.inner >> k & 1U) != 0;
      if (inner && node.child[k] != next++) {
        throw std::invalid_argument("sphere tree file: nodes are not in breadth-first order");
      }
    }
  }
}

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error("not a sound sphere-tree file: " + what);
}

void require(bool condition, const char* what) {
  if (!condition) refuse(what);
}

std::string at(std::size_t index) { return " " + std::to_string(index); }

bool is_length(double value) { return value >= 0.0 && value <= kMaxFileLength; }

bool is_sphere(const Sphere& sphere) {
  return (sphere.p.array().abs() <= kMaxFileLength).all() && is_length(sphere.r);
}

/// Takes numbers off the front of bytes.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::span<const std::uint8_t> take(std::size_t count) {
    require(count <= bytes_.size(), "it ends too early");
    const std::span<const std::uint8_t> taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return taken;
  }
  std::uint32_t u32() { return static_cast<std::uint32_t>(unsigned_integer(4)); }
  std::uint8_t u8() { return take(1)[0]; }
  double f64() { return std::bit_cast<double>(unsigned_integer(8)); }
  Sphere sphere() {
    Sphere sphere;
    for (int k = 0; k < 3; ++k) sphere.p[k] = f64();
    sphere.r = f64();
    return sphere;
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

 private:
  std::uint64_t unsigned_integer(std::size_t count) {
    std::uint64_t value = 0;
    unsigned shift = 0;
    for (const std::uint8_t byte : take(count)) {
      value |= std::uint64_t{byte} << shift;
      shift += 8;
    }
    return value;
  }

  std::span<const std::uint8_t> bytes_;
};

struct Counts {
  std::size_t leaves = 0, nodes = 0, levels = 0, name = 0;
  bool blended = false;
};

Counts read_counts(ByteReader& reader) {
  const std::span<const std::uint8_t> magic = reader.take(kMagic.size());
  require(std::equal(magic.begin(), magic.end(), kMagic.begin()),
          "it does not begin with the mark of one");
  const std::uint32_t version = reader.u32();
  if (version != kVersion && version != kBlendedVersion) {
    refuse("version " + std::to_string(version) + " is not " + std::to_string(kVersion) + " or " +
           std::to_string(kBlendedVersion) + "; build it again with this hapticd-model");
  }
  Counts counts;
  counts.blended = version == kBlendedVersion;
  counts.leaves = reader.u32();
  counts.nodes = reader.u32();
  counts.levels = reader.u32();
  counts.name = reader.u32();
  require(counts.leaves >= 1, "it has no leaves");
  require(counts.nodes >= 1, "it has no nodes");
  require(counts.levels >= 1 && counts.levels <= kMaxTreeDepth, "number of levels out of range");
  require(counts.name <= kMaxSourceName, "the name of the source is too long");
  const std::size_t least = counts.leaves * kLeafBytes + counts.nodes * kMinNodeBytes +
                            counts.levels * kLevelBytes + counts.name;
  require(least <= reader.left(), "it is too short for its counts");
  return counts;
}

void read_levels(ByteReader& reader, std::size_t count, MeasuredTree& file) {
  for (std::size_t i = 0; i < count; ++i) {
    TreeLevel level;
    level.spheres = static_cast<std::int32_t>(reader.u32());
    level.outer = reader.f64();
    level.mean = reader.f64();
    require(is_length(level.outer) && is_length(level.mean), "length in the level table");
    file.levels.push_back(level);
  }
}

void read_leaves(ByteReader& reader, std::size_t count, SphereTree& tree) {
  for (std::vector<double>* column : {&tree.leaf_x, &tree.leaf_y, &tree.leaf_z, &tree.leaf_r}) {
    column->reserve(count);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Sphere leaf = reader.sphere();
    if (!is_sphere(leaf)) refuse("leaf" + at(i) + " is not a sphere within 1000 m");
    tree.leaf_x.push_back(leaf.p.x());
    tree.leaf_y.push_back(leaf.p.y());
    tree.leaf_z.push_back(leaf.p.z());
    tree.leaf_r.push_back(leaf.r);
  }
}

void fill_slot(SphereTreeNode& node, std::size_t slot, const Sphere& bound, std::int32_t child) {
  node.x[slot] = bound.p.x();
  node.y[slot] = bound.p.y();
  node.z[slot] = bound.p.z();
  node.r[slot] = bound.r;
  node.child[slot] = child;
}

/// Whether `leaf` lies in `bound`; when true, then in exact arithmetic too.
bool contains(const Sphere& bound, const Sphere& leaf) {
  if (bound.p == leaf.p) return bound.r >= leaf.r;
  // kMinLength covers distances whose squares vanish.
  return (length(leaf.p - bound.p) + leaf.r) * kRoundUp + kMinLength <= bound.r;
}

/// Reads nodes one by one and checks each against those above it.
class NodeReader {
 public:
  NodeReader(ByteReader& reader, const Counts& counts, SphereTree& tree)
      : reader_(reader), tree_(tree), seen_(counts.leaves) {
    tree_.nodes.reserve(counts.nodes);
    above_.reserve(counts.nodes);
    above_.push_back({tree.bound, 0, 1});
    for (std::size_t n = 0; n < counts.nodes; ++n) read_node(n, counts.nodes);
    require(above_.size() == counts.nodes, "fewer links than nodes");
    require(leaves_ == counts.leaves, "a leaf belongs to no node");
  }

 private:
  /// Where a node hangs: its bound, the node that holds it, its level (1 = root).
  struct Place {
    Sphere bound;
    std::size_t node;
    int level;
  };

  void read_node(std::size_t n, std::size_t count) {
    if (n >= above_.size()) refuse("node" + at(n) + " has no parent");
    tree_.depth = std::max(tree_.depth, above_[n].level);
    require(tree_.depth <= kMaxTreeDepth, "it is too deep");
    SphereTreeNode node{};
    node.r.fill(-std::numeric_limits<double>::infinity());
    node.child.fill(kNoChild);
    node.used = reader_.u8();
    node.inner = reader_.u8();
    if (node.used == 0 || (node.inner & ~node.used) != 0) refuse("masks of node" + at(n));
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      if ((node.inner >> k & 1U) != 0) {
        read_inner(node, k, n, count);
      } else if ((node.used >> k & 1U) != 0) {
        read_leaf(node, k, n);
      }
    }
    tree_.nodes.push_back(node);
  }

  void read_inner(SphereTreeNode& node, std::size_t slot, std::size_t n, std::size_t count) {
    const Sphere bound = reader_.sphere();
    if (!is_sphere(bound)) refuse("a bound in node" + at(n) + " is not a sphere within 1000 m");
    require(above_.size() < count, "more links than nodes");
    fill_slot(node, slot, bound, static_cast<std::int32_t>(above_.size()));
    above_.push_back({bound, n, above_[n].level + 1});
  }

  void read_leaf(SphereTreeNode& node, std::size_t slot, std::size_t n) {
    const std::uint32_t i = reader_.u32();
    if (i >= seen_.size() || seen_[i]) {
      refuse("a leaf of node" + at(n) + " is missing or taken already");
    }
    seen_[i] = true;
    ++leaves_;
    const Sphere leaf{{tree_.leaf_x[i], tree_.leaf_y[i], tree_.leaf_z[i]}, tree_.leaf_r[i]};
    fill_slot(node, slot, leaf, ~static_cast<std::int32_t>(i));
    std::size_t m = n;
    for (bool more = true; more; m = above_[m].node) {
      more = m != 0;
      if (!contains(above_[m].bound, leaf)) {
        refuse("leaf" + at(i) + " sticks out of the bound of node" + at(m));
      }
    }
  }

  ByteReader& reader_;
  SphereTree& tree_;
  std::vector<Place> above_;
  std::vector<bool> seen_;
  std::size_t leaves_ = 0;
};

void read_blend(ByteReader& reader, SphereTree& tree) {
  const double width = reader.f64();
  require(width >= kMinBlend && width <= kMaxFileLength, "the width of its blend");
  blend_surface(width, tree);
}

void check_levels(const MeasuredTree& file) {
  const std::vector<std::int32_t> spheres = spheres_per_level(file.tree);
  require(std::equal(spheres.begin(), spheres.end(), file.levels.begin(), file.levels.end(),
                     [](std::int32_t n, const TreeLevel& level) { return n == level.spheres; }),
          "the level table does not fit the tree");
}

}  // namespace

ContentHash content_hash(std::span<const std::uint8_t> bytes) {
  ContentHash hash{};
  if (sodium_init() < 0 ||
      crypto_generichash(hash.data(), hash.size(), bytes.data(), bytes.size(), nullptr, 0) != 0) {
    throw std::runtime_error("the hash of libsodium does not work on this machine");
  }
  return hash;
}

std::vector<std::uint8_t> encode_sphere_tree(const MeasuredTree& file) {
  const SphereTree& tree = file.tree;
  check_links(tree);
  Bytes out(kMagic.begin(), kMagic.end());
  put(out, tree.blend.width > 0.0 ? kBlendedVersion : kVersion);
  for (const std::size_t count :
       {tree.leaf_r.size(), tree.nodes.size(), file.levels.size(), file.source_name.size()}) {
    put(out, static_cast<std::uint32_t>(count));
  }
  out.insert(out.end(), file.source.begin(), file.source.end());
  put(out, file.outer);
  put(out, file.inner);
  put(out, tree.bound.p.x(), tree.bound.p.y(), tree.bound.p.z(), tree.bound.r);
  for (const TreeLevel& level : file.levels) {
    put(out, static_cast<std::uint32_t>(level.spheres));
    put(out, level.outer);
    put(out, level.mean);
  }
  out.insert(out.end(), file.source_name.begin(), file.source_name.end());
  for (std::size_t i = 0; i < tree.leaf_r.size(); ++i) {
    put(out, tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i], tree.leaf_r[i]);
  }
  for (const SphereTreeNode& node : tree.nodes) put_node(out, node);
  if (tree.blend.width > 0.0) put(out, tree.blend.width);
  const ContentHash hash = content_hash(out);
  out.insert(out.end(), hash.begin(), hash.end());

  // The reader's checks are the only ones: what it takes is sound.
  try {
    static_cast<void>(decode_sphere_tree(out));
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
  return out;
}

MeasuredTree decode_sphere_tree(std::span<const std::uint8_t> bytes) {
  ByteReader reader(bytes);
  const Counts counts = read_counts(reader);
  // Damage is distinguished from a wrong tree first: it explains the failure best.
  ContentHash stored{};
  require(reader.left() >= stored.size(), "it ends too early");
  const std::span<const std::uint8_t> tail = bytes.last(stored.size());
  std::copy(tail.begin(), tail.end(), stored.begin());
  const std::span<const std::uint8_t> content = bytes.first(bytes.size() - stored.size());
  require(content_hash(content) == stored, "its content and its hash differ; it is damaged");
  reader = ByteReader(content.last(reader.left() - stored.size()));

  MeasuredTree file;
  const std::span<const std::uint8_t> source = reader.take(file.source.size());
  std::copy(source.begin(), source.end(), file.source.begin());
  file.outer = reader.f64();
  file.inner = reader.f64();
  require(is_length(file.outer) && is_length(file.inner), "its outer or inner bound");
  file.tree.bound = reader.sphere();
  require(is_sphere(file.tree.bound), "its bound is not a sphere within 1000 m");
  read_levels(reader, counts.levels, file);
  const std::span<const std::uint8_t> name = reader.take(counts.name);
  file.source_name.assign(name.begin(), name.end());
  // It is shown on terminals.
  require(
      std::all_of(name.begin(), name.end(), [](std::uint8_t c) { return c >= 0x20 && c != 0x7f; }),
      "the name of the source holds control characters");
  read_leaves(reader, counts.leaves, file.tree);
  const NodeReader nodes(reader, counts, file.tree);
  if (counts.blended) read_blend(reader, file.tree);
  require(reader.left() == 0, "bytes are left over");
  check_levels(file);
  file.tree.overhang = largest_overhang(file.tree);
  file.tree.boxes = bounding_boxes(file.tree);
  return file;
}

}  // namespace hapticd
