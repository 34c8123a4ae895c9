// The hash and the writer; the reader, which trusts nothing, is sphere_tree_file_read.cpp. See
// sphere_tree_file.h.
#include "server/scene_io/sphere_tree_file.h"

#include <sodium.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "server/scene_io/sphere_tree_layout.h"

namespace hapticd {
namespace {

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
  Bytes out(kTreeFileMagic.begin(), kTreeFileMagic.end());
  put(out, kTreeFileVersion);
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

}  // namespace hapticd
