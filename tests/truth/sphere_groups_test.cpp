// Groups hide no sphere. Truth: every sphere looked at.
#include "tests/truth/sphere_groups.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("every sphere is visited once and in order, or lies in a ball that is far") {
  SplitMix64 random(1);
  const auto somewhere = [&] {
    return Vector3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
  };
  for (int scene = 0; scene < scaled(1000); ++scene) {
    std::vector<Sphere> spheres(random.below(100));
    for (Sphere& sphere : spheres)
      sphere = {somewhere(), std::pow(10.0, random.uniform(-6.0, 0.0))};
    const Pose X{Quaternion(1.0, 2.0, -3.0, 0.5).normalized(), 100.0 * somewhere()};
    const Vector3 p = X.p + somewhere();
    const double reach = random.uniform(0.0, 1.0);
    std::size_t next = 0;
    const auto must_be_far = [&](std::size_t end) {
      for (; next < end; ++next) {
        REQUIRE((transform(X, spheres[next].p) - p).norm() - spheres[next].r > reach);
      }
    };
    visit_spheres(
        group_spheres(spheres), X,
        [&](const Sphere& ball) { return (ball.p - p).norm() - ball.r > reach; },
        [&](std::size_t i) {
          must_be_far(i);
          REQUIRE(next++ == i);
        });
    must_be_far(spheres.size());
  }
}

}  // namespace hapticd::test
