// The file of a sphere-tree: nothing is lost, the layout is the one written down, and whatever the
// bytes are, what is read is sound. Truth: bytes put together by hand, the inspector of trees.
#include "server/scene_io/sphere_tree_file.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>

#include "tests/core/tree/sphere_families.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/tree_inspector.h"

namespace hapticd::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

MeasuredTree file_of(const std::vector<Sphere>& spheres) {
  MeasuredTree file;
  file.tree = build_sphere_tree(spheres);
  file.source.fill(0x5a);
  file.source_name = "a mesh.ply";
  file.outer = 250e-6;
  file.inner = 10e-6;
  for (const std::int32_t n : spheres_per_level(file.tree)) file.levels.push_back({n, 0.01, 1e-3});
  return file;
}

MeasuredTree random_file(int leaves, std::uint64_t seed) {
  return file_of(sphere_families(leaves, seed).front().spheres);
}

/// The bytes with the hash at their end made again, so that the reader looks at their structure.
Bytes rehashed(Bytes bytes) {
  const std::size_t content = bytes.size() - std::min(bytes.size(), sizeof(ContentHash));
  bytes.resize(content);
  const ContentHash hash = content_hash(bytes);
  bytes.insert(bytes.end(), hash.begin(), hash.end());
  return bytes;
}

/// What the reader says; "" when it reads.
std::string complaint(const Bytes& bytes) {
  try {
    static_cast<void>(decode_sphere_tree(bytes));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// Whether the bytes are refused, or read as a sound tree that gives the same bytes.
bool refused_or_sound(const Bytes& bytes) {
  MeasuredTree file;
  try {
    file = decode_sphere_tree(bytes);
  } catch (const std::runtime_error&) {
    return true;
  }
  const SphereTreeView view = file.tree.view();
  const std::vector<Sphere> leaves = leaves_of(view);
  return TreeInspector(view, leaves).sound() && encode_sphere_tree(file) == bytes;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return same_bits(x, y); });
}

bool same_tree(const SphereTree& a, const SphereTree& b) {
  const auto same_node = [](const SphereTreeNode& m, const SphereTreeNode& n) {
    return m.x == n.x && m.y == n.y && m.z == n.z && m.r == n.r && m.child == n.child &&
           m.used == n.used && m.inner == n.inner;
  };
  return same_bits(a.leaf_x, b.leaf_x) && same_bits(a.leaf_y, b.leaf_y) &&
         same_bits(a.leaf_z, b.leaf_z) && same_bits(a.leaf_r, b.leaf_r) && a.bound.p == b.bound.p &&
         a.bound.r == b.bound.r && a.depth == b.depth && same_bits(a.overhang, b.overhang) &&
         std::equal(a.nodes.begin(), a.nodes.end(), b.nodes.begin(), b.nodes.end(), same_node);
}

/// Puts a file together as its description says.
struct ByteWriter {
  Bytes bytes;

  ByteWriter& raw(const char* text) {
    for (; *text != '\0'; ++text) bytes.push_back(static_cast<std::uint8_t>(*text));
    return *this;
  }
  ByteWriter& u8(unsigned value) {
    bytes.push_back(static_cast<std::uint8_t>(value));
    return *this;
  }
  ByteWriter& u32(std::uint32_t value) {
    for (int k = 0; k < 4; ++k) u8(value >> (8 * k) & 0xffU);
    return *this;
  }
  ByteWriter& f64(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    return u32(static_cast<std::uint32_t>(bits)).u32(static_cast<std::uint32_t>(bits >> 32U));
  }
  ByteWriter& sphere(double x, double y, double z, double r) { return f64(x).f64(y).f64(z).f64(r); }
};

/// Header of a tree of two leaves with one node, up to its bound.
ByteWriter header_by_hand(std::uint32_t leaves, std::uint32_t nodes, std::uint32_t levels) {
  ByteWriter file;
  file.raw("HDTREE\r\n").u32(1).u32(leaves).u32(nodes).u32(levels).u32(3);
  for (unsigned k = 0; k < 32; ++k) file.u8(k);
  file.f64(0.5).f64(0.25);
  return file;
}

/// Two unit spheres at x = -1 and x = 1 in one node, the second leaf first.
Bytes two_leaves_by_hand(double bound_radius) {
  ByteWriter file = header_by_hand(2, 1, 1);
  file.sphere(0, 0, 0, bound_radius).u32(2).f64(0.5).f64(0.125).raw("abc");
  file.sphere(-1, 0, 0, 1).sphere(1, 0, 0, 1);
  file.u8(0b101).u8(0).u32(1).u32(0);
  file.bytes.resize(file.bytes.size() + 32);
  return rehashed(file.bytes);
}

/// Each node holds one leaf and, but the last, one more node: as deep as asked.
Bytes chain_by_hand(std::uint32_t levels) {
  ByteWriter file = header_by_hand(levels, levels, std::min(levels, 12U));
  file.sphere(0, 0, 0, 2);
  for (std::uint32_t k = 1; k <= std::min(levels, 12U); ++k) {
    file.u32(std::min(k + 1, levels)).f64(0.5).f64(0.125);
  }
  file.raw("abc");
  for (std::uint32_t k = 0; k < levels; ++k) file.sphere(0, 0, 0, 1);
  for (std::uint32_t k = 0; k + 1 < levels; ++k) file.u8(3).u8(2).u32(k).sphere(0, 0, 0, 2);
  file.u8(1).u8(0).u32(levels - 1);
  file.bytes.resize(file.bytes.size() + 32);
  return rehashed(file.bytes);
}

/// The same two spheres, blended over `width`.
Bytes blended_by_hand(double width) {
  Bytes bytes = two_leaves_by_hand(2.5);
  bytes[8] = 2;
  bytes.resize(bytes.size() - 32);
  ByteWriter file{bytes};
  file.f64(width);
  file.bytes.resize(file.bytes.size() + 32);
  return rehashed(file.bytes);
}

}  // namespace

TEST_CASE("the content hash is BLAKE2b with 256 bits") {
  // Values of another implementation (Python's hashlib).
  const auto hex = [](const ContentHash& hash) {
    std::string text;
    for (const std::uint8_t byte : hash) {
      text += "0123456789abcdef"[byte >> 4U];
      text += "0123456789abcdef"[byte & 15U];
    }
    return text;
  };
  CHECK(hex(content_hash({})) ==
        "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
  CHECK(hex(content_hash(Bytes{'a', 'b', 'c'})) ==
        "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319");
}

TEST_CASE("a tree comes back from its file with the same bits, whatever its shape") {
  for (std::int64_t trial = 0; trial < scaled(100); ++trial) {
    for (const SphereFamily& family :
         sphere_families(static_cast<int>(1 + trial * trial % 700), 7)) {
      // "all sizes" and its like reach lengths that no object has.
      const bool fits =
          std::all_of(family.spheres.begin(), family.spheres.end(),
                      [](const Sphere& s) { return s.p.norm() + s.r < 0.4 * kMaxFileLength; });
      if (!fits) continue;
      CAPTURE(family.name);
      const MeasuredTree file = file_of(family.spheres);
      const MeasuredTree back = decode_sphere_tree(encode_sphere_tree(file));
      REQUIRE(same_tree(back.tree, file.tree));
      REQUIRE(back.source == file.source);
      REQUIRE(back.source_name == file.source_name);
      REQUIRE(back.outer == file.outer);
      REQUIRE(back.inner == file.inner);
      REQUIRE(back.levels.size() == static_cast<std::size_t>(file.tree.depth));
      REQUIRE(back.levels.back().spheres == static_cast<std::int32_t>(family.spheres.size()));
    }
  }
}

TEST_CASE("a file put together by hand after the description is read as it was meant") {
  const MeasuredTree file = decode_sphere_tree(two_leaves_by_hand(2.5));
  CHECK(file.source[31] == 31);
  CHECK(file.source_name == "abc");
  CHECK(file.outer == 0.5);
  CHECK(file.inner == 0.25);
  CHECK(file.tree.bound.r == 2.5);
  CHECK(file.tree.depth == 1);
  CHECK(file.tree.nodes[0].child == std::array<std::int32_t, 8>{~1, kNoChild, ~0, kNoChild,
                                                                kNoChild, kNoChild, kNoChild,
                                                                kNoChild});
  CHECK(file.tree.leaf_x == std::vector<double>{-1, 1});
  CHECK(file.levels[0].mean == 0.125);
  CHECK(encode_sphere_tree(file) == two_leaves_by_hand(2.5));
  CHECK(file.tree.view().blend.width == 0.0);
}

TEST_CASE("the second version of the file has the width of a blend, from 1 um on") {
  const MeasuredTree file = decode_sphere_tree(blended_by_hand(0.25));
  CHECK(file.tree.view().blend.width == 0.25);
  CHECK(file.tree.view().blend.least_radius == 1.0);
  CHECK(encode_sphere_tree(file) == blended_by_hand(0.25));
  for (const double width : {0.0, -1.0, 1e-7, 2e3, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(complaint(blended_by_hand(width)).find("blend") != std::string::npos);
  }
  Bytes third = blended_by_hand(0.25);
  third[8] = 3;
  CHECK(complaint(rehashed(third)).find("version 3") != std::string::npos);
}

TEST_CASE("a bound that lets a leaf out is refused, even by less than a rounding") {
  CHECK(complaint(two_leaves_by_hand(2.0 * (1 + 8e-15))).empty());
  CHECK(complaint(two_leaves_by_hand(std::nextafter(2.0, 0.0))).find("sticks out") !=
        std::string::npos);
  CHECK(complaint(two_leaves_by_hand(1.0)).find("sticks out") != std::string::npos);
}

TEST_CASE("a leaf that belongs to no node is refused, and so is a level table of another tree") {
  const auto with = [](std::uint32_t leaves, std::uint32_t in_table) {
    ByteWriter file = header_by_hand(leaves, 1, 1);
    file.sphere(0, 0, 0, 2).u32(in_table).f64(0.5).f64(0.125).raw("abc");
    for (std::uint32_t k = 0; k < leaves; ++k) file.sphere(0, 0, 0, 1);
    file.u8(3).u8(0).u32(1).u32(0);
    file.bytes.resize(file.bytes.size() + 32);
    return complaint(rehashed(file.bytes));
  };
  CHECK(with(2, 2).empty());
  CHECK(with(3, 2).find("belongs to no node") != std::string::npos);
  CHECK(with(2, 3).find("level table") != std::string::npos);
}

TEST_CASE("a tree may be twelve levels deep and not deeper") {
  CHECK(complaint(chain_by_hand(12)).empty());
  CHECK(complaint(chain_by_hand(13)).find("too deep") != std::string::npos);
}

TEST_CASE("a file cut off anywhere is refused, with its hash made again too") {
  const Bytes bytes = encode_sphere_tree(random_file(30, 3));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    CAPTURE(length);
    REQUIRE_FALSE(complaint(cut).empty());
    REQUIRE_FALSE(complaint(rehashed(cut)).empty());
  }
}

TEST_CASE("bytes after the end are refused") {
  Bytes bytes = encode_sphere_tree(random_file(30, 3));
  bytes.insert(bytes.end() - 32, 0);
  CHECK(complaint(rehashed(bytes)).find("left over") != std::string::npos);
}

TEST_CASE("a change of any byte is noticed") {
  const Bytes bytes = encode_sphere_tree(random_file(30, 4));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    Bytes changed = bytes;
    changed[i] ^= 0x10U;
    CAPTURE(i);
    REQUIRE_FALSE(complaint(changed).empty());
  }
}

TEST_CASE("with its hash made again a changed file is refused or reads as a sound tree") {
  SplitMix64 random(5);
  const Bytes bytes = encode_sphere_tree(random_file(30, 5));
  for (std::size_t i = 0; i + 32 < bytes.size(); ++i) {
    for (const unsigned value : {bytes[i] ^ 1U, bytes[i] ^ 0x80U, 0U, 0xffU, bytes[i] + 1U}) {
      Bytes changed = bytes;
      changed[i] = static_cast<std::uint8_t>(value);
      CAPTURE(i);
      REQUIRE(refused_or_sound(rehashed(changed)));
    }
  }
  for (std::int64_t trial = 0; trial < scaled(20'000); ++trial) {
    Bytes changed = bytes;
    for (std::uint64_t k = 1 + random.below(4); k > 0; --k) {
      changed[random.below(bytes.size())] = static_cast<std::uint8_t>(random.next());
    }
    REQUIRE(refused_or_sound(rehashed(changed)));
  }
}

TEST_CASE("counts far beyond the file are refused before memory is taken") {
  const Bytes bytes = encode_sphere_tree(random_file(30, 6));
  // Leaves, nodes, levels and length of the name.
  for (const std::size_t offset : {12U, 16U, 20U, 24U}) {
    for (const unsigned high : {0x01U, 0x7fU, 0x80U, 0xffU}) {
      Bytes changed = bytes;
      changed[offset + 3] = static_cast<std::uint8_t>(high);
      CAPTURE(offset);
      REQUIRE_FALSE(complaint(rehashed(changed)).empty());
    }
  }
}

TEST_CASE("what is no sphere is not written") {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), -1.0, 1001.0}) {
    MeasuredTree file = random_file(20, 8);
    file.tree.leaf_r[3] = bad;
    CHECK_THROWS_AS(static_cast<void>(encode_sphere_tree(file)), std::invalid_argument);
    file = random_file(20, 8);
    file.outer = bad;
    CHECK_THROWS_AS(static_cast<void>(encode_sphere_tree(file)), std::invalid_argument);
  }
}

TEST_CASE("a name that would disturb a terminal or is too long is refused") {
  MeasuredTree file = random_file(3, 9);
  file.source_name = std::string(kMaxSourceName, 'x');
  CHECK_NOTHROW(static_cast<void>(encode_sphere_tree(file)));
  file.source_name += 'x';
  CHECK_THROWS_AS(static_cast<void>(encode_sphere_tree(file)), std::invalid_argument);
  file.source_name = "\x1b[2J";
  CHECK_THROWS_AS(static_cast<void>(encode_sphere_tree(file)), std::invalid_argument);
}

}  // namespace hapticd::test
