// How well the bunny is packed, measured against the best published packing of it (G. Bradshaw and
// C. O'Sullivan, "Adaptive medial-axis approximation for sphere-tree construction", ACM TOG 2004;
// its program run on the same mesh and judged by the same evaluator): in % of the diagonal, 64
// spheres 3.65 at worst and 1.38 in the mean with 0.14 % uncovered, 490 spheres 2.0 and 0.34 with
// 1.58 % uncovered. Truth: the exact distances of packing_report.
#include <doctest/doctest.h>

#include <string>

#include "server/model/mesh_file.h"
#include "server/model/packing/packing_report.h"
#include "server/model/tree_report.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

struct Quality {
  std::size_t spheres = 0;
  double worst = 0.0, mean = 0.0;  ///< outside, % of the diagonal
  double uncovered = 0.0;          ///< share of the surface
  double beyond = 0.0;             ///< worst over the bound that the tree states
};

Quality measure(const std::string& name) {
  const std::string folder = HAPTICD_MODELS_DIR;
  const TriangleMesh mesh = read_mesh(folder + "/bunny.ply", 1.0).mesh;
  const MeasuredTree file =
      decode_sphere_tree(read_bytes(folder + "/" + name, std::uint64_t{1} << 30U));
  const std::vector<Sphere> leaves = level_spheres(file.tree, file.tree.depth);
  ReportOptions options;
  options.samples = 10'000 + scaled(2'000'000);
  const PackingReport report = report_packing(mesh, MeshDistance(mesh), leaves, options);
  return {leaves.size(), 100.0 * report.outside.max / report.diagonal,
          100.0 * report.outside.mean / report.diagonal, report.uncovered,
          report.outside.max / file.outer};
}

}  // namespace

// The limits are 1.2 times what is reached.
TEST_CASE("64 spheres hold the bunny all over, with half the error of the published packing") {
  const Quality quality = measure("bunny_64.tree");
  CHECK(quality.spheres <= 64);
  CHECK(quality.worst <= 1.2 * 1.73);
  CHECK(quality.mean <= 1.2 * 1.02);
  CHECK(quality.uncovered == 0.0);
  CHECK(quality.beyond <= 1.0);
}

TEST_CASE(
    "500 spheres hold the bunny all over, with a quarter of the worst error of the published "
    "packing") {
  const Quality quality = measure("bunny_500.tree");
  CHECK(quality.spheres <= 500);
  CHECK(quality.worst <= 1.2 * 0.43);
  CHECK(quality.mean <= 1.2 * 0.241);
  CHECK(quality.uncovered == 0.0);
  CHECK(quality.beyond <= 1.0);
}

}  // namespace hapticd::test
