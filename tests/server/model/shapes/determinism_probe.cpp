// Prints one hash per model: of its mesh, and for some of the bytes of a tree file made from it.
// Equal output of two builds means that a tree is the same byte by byte, whatever the compiler;
// deploy/test --full compares builds. The trees are coarse, for builds that are not
// optimised.
#include <bit>
#include <cinttypes>
#include <cstdio>
#include <string>

#include "server/model/packing/sphere_packing.h"
#include "server/model/shapes/model_catalogue.h"
#include "server/scene_io/sphere_tree_file.h"

namespace {

using hapticd::TriangleMesh;

class Hash {
 public:
  void add(std::uint64_t bits) noexcept {
    for (unsigned shift = 0; shift < 64; shift += 8) {
      hash_ = (hash_ ^ ((bits >> shift) & 0xffU)) * 0x100000001b3U;
    }
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

std::uint64_t hash_of(const TriangleMesh& mesh) {
  Hash hash;
  for (const hapticd::Vector3& p : mesh.vertices) {
    for (const double number : {p.x(), p.y(), p.z()})
      hash.add(std::bit_cast<std::uint64_t>(number));
  }
  for (const hapticd::Triangle& triangle : mesh.triangles) {
    for (const std::int32_t i : triangle) hash.add(static_cast<std::uint64_t>(i));
  }
  return hash.value();
}

/// Of the bytes of the tree with this bound, or with at most so many leaves.
void print_tree(const char* name, double outer, int leaves, int threads) {
  const TriangleMesh mesh = hapticd::find_model(name)->make({});
  hapticd::PackingOptions options;
  options.outer = outer;
  if (leaves > 0) options.leaves = leaves;
  options.threads = threads;
  const hapticd::Packing packing =
      hapticd::pack_spheres(mesh, hapticd::MeshDistance(mesh), options);
  hapticd::MeasuredTree file;
  file.tree = hapticd::build_sphere_tree(packing.leaves);
  file.outer = packing.outer;
  for (const std::int32_t spheres : hapticd::spheres_per_level(file.tree)) {
    file.levels.push_back({spheres, packing.outer, 0.0});
  }
  Hash hash;
  for (const std::uint8_t byte : hapticd::encode_sphere_tree(file)) hash.add(byte);
  std::printf("%s.tree %016" PRIx64 "\n", name, hash.value());
}

}  // namespace

int main() {
  for (const hapticd::NamedModel& model : hapticd::model_catalogue()) {
    std::printf("%s %016" PRIx64 "\n", std::string(model.name).c_str(), hash_of(model.make({})));
  }
  print_tree("index_tip", 600e-6, 0, 2);
  print_tree("guqin_bridge", 0.0, 8, 2);
  print_tree("bracket", 8e-3, 0, 1);
}
