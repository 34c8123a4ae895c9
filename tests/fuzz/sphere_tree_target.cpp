// See sphere_tree_target.h.
#include "tests/fuzz/sphere_tree_target.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "server/scene_io/sphere_tree_file.h"
#include "tests/support/tree_inspector.h"

namespace hapticd::test {
namespace {

bool check(const std::vector<std::uint8_t>& bytes) {
  MeasuredTree file;
  try {
    file = decode_sphere_tree(bytes);
  } catch (const std::runtime_error&) {
    return false;
  }
  const SphereTreeView view = file.tree.view();
  const std::vector<Sphere> leaves = leaves_of(view);
  if (!TreeInspector(view, leaves).sound()) throw std::logic_error("the tree is not sound");
  if (encode_sphere_tree(file) != bytes) throw std::logic_error("the bytes are not the same again");
  return true;
}

}  // namespace

bool check_sphere_tree_bytes(std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());
  const bool as_it_is = check(copy);
  copy.resize(copy.size() - std::min(copy.size(), sizeof(ContentHash)));
  const ContentHash hash = content_hash(copy);
  copy.insert(copy.end(), hash.begin(), hash.end());
  return check(copy) || as_it_is;
}

}  // namespace hapticd::test
