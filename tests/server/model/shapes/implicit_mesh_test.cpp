// The mesher of implicit functions against spheres, tori and pairs of balls in closed form, and the
// shapes it is used with against a search.
#include "server/model/shapes/implicit_mesh.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "server/model/shapes/implicit_shape.h"
#include "tests/server/model/shapes/mesh_measures.h"
#include "tests/server/model/shapes/relative.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kPi = std::numbers::pi;

ImplicitMeshOptions cube(double half, double cell) {
  ImplicitMeshOptions options;
  options.low = Vector3::Constant(-half);
  options.high = Vector3::Constant(half);
  options.cell = cell;
  return options;
}

Vector3 random_vector(SplitMix64& random, double size) {
  const double x = random.uniform(-size, size);
  const double y = random.uniform(-size, size);
  return {x, y, random.uniform(-size, size)};
}

/// Least distance of p from the spheres between the two ends, by narrowing down.
long double searched_distance(const RoundCone& cone, const Vector3& p) {
  const auto at = [&](long double t) {
    long double square = 0.0L;
    for (int i = 0; i < 3; ++i) {
      const long double centre =
          cone.p_a[i] + t * (static_cast<long double>(cone.p_b[i]) - cone.p_a[i]);
      square += (p[i] - centre) * (p[i] - centre);
    }
    return std::sqrt(square) - (cone.r_a + t * (static_cast<long double>(cone.r_b) - cone.r_a));
  };
  long double low = 0.0L;
  long double high = 1.0L;
  for (int k = 0; k < 200; ++k) {
    const long double third = (high - low) / 3.0L;
    if (at(low + third) < at(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return std::min({at(low), at(0.0L), at(1.0L)});
}

}  // namespace

TEST_CASE("a meshed ball has its vertices on the sphere, its volume and its area") {
  const auto ball = [](const Vector3& p) { return p.norm() - 1.0; };
  double last_error = 1.0;
  for (const double cell : {0.4, 0.2, 0.1}) {
    const TriangleMesh mesh = mesh_implicit(ball, cube(1.9, cell));
    const MeshMeasures measures = measure(mesh);
    CHECK(measures.closed);
    CHECK(measures.euler == 2);
    double worst = 0.0;
    for (const Vector3& p : mesh.vertices) worst = std::max(worst, std::fabs(p.norm() - 1.0));
    CHECK(worst < 1e-12);
    const double volume = static_cast<double>(measures.volume) / (4.0 / 3.0 * kPi);
    CHECK(volume < 1.0);
    CHECK(1.0 - volume < cell * cell);
    CHECK(1.0 - static_cast<double>(measures.area) / (4.0 * kPi) < cell * cell);
    // Of second order in the cell.
    CHECK(1.0 - volume < last_error / 3.0);
    last_error = 1.0 - volume;
  }
}

TEST_CASE("vertices lie on the level of a function that is no distance, too") {
  const auto steep = [](const Vector3& p) { return (p.squaredNorm() - 1.0) * (1.0 + 0.4 * p.x()); };
  double worst = 0.0;
  for (const Vector3& p : mesh_implicit(steep, cube(1.9, 0.25)).vertices) {
    worst = std::max(worst, std::fabs(p.norm() - 1.0));
  }
  CHECK(worst < 1e-9);
}

TEST_CASE("wherever the lattice lies, a ball's mesh is closed and has no slivers") {
  SplitMix64 random(1);
  for (std::int64_t k = 0; k < scaled(400); ++k) {
    const Vector3 centre = random_vector(random, 0.3);
    const double radius = random.uniform(0.5, 1.1);
    ImplicitMeshOptions options = cube(2.0, 0.3);
    options.rounds = static_cast<int>(random.below(4));
    const TriangleMesh mesh =
        mesh_implicit([&](const Vector3& p) { return (p - centre).norm() - radius; }, options);
    const MeshMeasures measures = measure(mesh);
    REQUIRE(measures.closed);
    REQUIRE(measures.euler == 2);
    REQUIRE(measures.volume > 0.0L);
    REQUIRE(measures.flattest > 0.12L);
  }
}

TEST_CASE("surfaces exactly on lattice points and planes are meshed too") {
  // Corners of the lattice lie on this sphere, and on this cube's faces. Not moved afterwards, the
  // mesh must keep what the lattice gave.
  const auto ball = [](const Vector3& p) { return p.norm() - 0.75; };
  const auto box = [](const Vector3& p) { return p.cwiseAbs().maxCoeff() - 0.75; };
  for (const ImplicitFunction& shape : {ImplicitFunction(ball), ImplicitFunction(box)}) {
    ImplicitMeshOptions options = cube(2.0, 0.25);
    options.rounds = 0;
    const MeshMeasures measures = measure(mesh_implicit(shape, options));
    CHECK(measures.closed);
    CHECK(measures.euler == 2);
    CHECK(measures.flattest > 0.05L);
  }
}

TEST_CASE("a torus keeps its hole") {
  const auto torus = [](const Vector3& p) {
    return std::hypot(std::hypot(p.x(), p.y()) - 1.0, p.z()) - 0.35;
  };
  const MeshMeasures measures = measure(mesh_implicit(torus, cube(1.7, 0.1)));
  CHECK(measures.closed);
  CHECK(measures.euler == 0);
  const double volume = 2.0 * kPi * kPi * 0.35 * 0.35;
  CHECK(static_cast<double>(measures.volume) == relative(volume, 0.02));
}

TEST_CASE("two balls apart are two pieces, blended together one, with more than their volume") {
  const auto first = [](const Vector3& p) { return (p - Vector3(-0.6, 0, 0)).norm() - 0.5; };
  const auto second = [](const Vector3& p) { return (p - Vector3(0.6, 0, 0)).norm() - 0.5; };
  const MeshMeasures apart = measure(mesh_implicit(
      [&](const Vector3& p) { return std::min(first(p), second(p)); }, cube(1.6, 0.08)));
  CHECK(apart.pieces == 2);
  CHECK(apart.euler == 4);
  const MeshMeasures joined = measure(mesh_implicit(
      [&](const Vector3& p) { return smooth_minimum(first(p), second(p), 0.6); }, cube(1.6, 0.08)));
  CHECK(joined.closed);
  CHECK(joined.pieces == 1);
  CHECK(joined.volume > apart.volume);
}

TEST_CASE("a solid that reaches the box, and a cell that makes no lattice, are refused") {
  const auto ball = [](const Vector3& p) { return p.norm() - 1.0; };
  const auto refused = [&](const ImplicitMeshOptions& options) {
    CHECK_THROWS_AS(static_cast<void>(mesh_implicit(ball, options)), std::invalid_argument);
  };
  refused(cube(1.0, 0.1));
  refused(cube(1.5, 0.0));
  refused(cube(1.5, -0.1));
  refused(cube(1.5, std::nan("")));
  refused(cube(1.5, 2.0));
  refused(cube(1.5, 1e-6));
  refused(cube(-1.5, 0.1));
}

TEST_CASE("the distance to a round cone is that to the nearest of its spheres") {
  SplitMix64 random(2);
  for (std::int64_t k = 0; k < scaled(20'000); ++k) {
    RoundCone cone;
    cone.p_a = random_vector(random, 1.0);
    cone.p_b = random_vector(random, 1.0);
    cone.r_a = random.uniform(0.0, 1.0);
    cone.r_b = random.uniform(0.0, 1.0);
    const Vector3 p = random_vector(random, 2.0);
    REQUIRE(std::fabs(static_cast<double>(distance(cone, p) - searched_distance(cone, p))) < 1e-9);
  }
}

TEST_CASE("a round cone of no length, or with one end in the other, is its larger sphere") {
  const RoundCone point{{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.5, 0.5};
  CHECK(distance(point, {3.0, 0.0, 0.0}) == 1.5);
  const RoundCone inner{{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, 0.2, 1.0};
  CHECK(distance(inner, {0.1, 3.0, 0.0}) == 2.0);
}

TEST_CASE("the smooth minimum is symmetric, grows with both and stays close below the minimum") {
  SplitMix64 random(3);
  for (std::int64_t k = 0; k < scaled(100'000); ++k) {
    const double blend = random.uniform(0.01, 1.0);
    const double a = random.uniform(-1.0, 1.0);
    const double b = random.uniform(-1.0, 1.0);
    const double smooth = smooth_minimum(a, b, blend);
    REQUIRE(smooth <= std::min(a, b));
    REQUIRE(smooth >= std::min(a, b) - 0.25 * blend);
    REQUIRE(smooth == smooth_minimum(b, a, blend));
    if (std::fabs(a - b) >= blend) REQUIRE(smooth == std::min(a, b));
    const double more = random.uniform(0.0, 0.5);
    REQUIRE(smooth_minimum(a + more, b, blend) >= smooth - 1e-15);
  }
}

}  // namespace hapticd::test
