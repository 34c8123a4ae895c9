// Pictures: the sphere is where it must be, what is uncovered is red and only that. Truth: the
// outline of a sphere, counted pixels.
#include "server/model/picture.h"

#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>

#include "tests/server/model/packing/test_meshes.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr double kRadius = 0.03;

TriangleMesh ball() { return ellipsoid_mesh(24, {kRadius, kRadius, kRadius}); }

Picture draw(const TriangleMesh& mesh, const std::vector<Sphere>& spheres) {
  return draw_packing(mesh, MeshDistance(mesh), spheres, {400, 200, 1e-3});
}

/// Share of a half's pixels that `is` holds of, left 0 or right 1.
template <typename Is>
double share(const Picture& picture, int half, const Is& is) {
  int count = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 200 * half; x < 200 * (half + 1); ++x) {
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * 400 + static_cast<std::size_t>(x));
      count += is(picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]) ? 1 : 0;
    }
  }
  return count / 40000.0;
}

bool is_red(int r, int g, int b) { return r > 60 && g < r / 4 && b < r / 4; }
/// The background is nearly grey.
bool is_shape(int r, int g, int b) { return std::abs(r - g) > 12 || std::abs(g - b) > 12; }

/// Share of a half that a disc of nine tenths of its side covers.
const double kDisc = 3.14159265 / 4.0 * 0.81;

}  // namespace

TEST_CASE("a ball and the sphere around it are two discs of the same size") {
  const Picture picture = draw(ball(), {{{0.0, 0.0, 0.0}, kRadius * 1.001}});
  CHECK(picture.rgb.size() == 3U * 400 * 200);
  // Its rim is shaded too dark to count.
  CHECK(share(picture, 0, is_shape) == within(kDisc, 0.1));
  CHECK(share(picture, 1, is_shape) == within(kDisc, 0.05));
  CHECK(share(picture, 0, is_red) == 0.0);
  CHECK(share(picture, 1, is_red) == 0.0);
}

TEST_CASE("what no sphere covers is red, on the side of the spheres") {
  const Picture picture = draw(ball(), {{{0.0, 0.0, 0.0}, kRadius * 0.9}});
  CHECK(share(picture, 0, is_red) == 0.0);
  CHECK(share(picture, 1, is_red) > 0.9 * kDisc);
}

TEST_CASE("the same input gives the same picture, and a PNG file of it") {
  const std::vector<Sphere> spheres{{{0.0, 0.0, 0.01}, 0.03}, {{0.0, 0.01, -0.01}, 0.025}};
  const Picture picture = draw(ball(), spheres);
  CHECK(picture.rgb == draw(ball(), spheres).rgb);
  const std::vector<std::uint8_t> png = encode_png(picture);
  REQUIRE(png.size() > 100);
  CHECK(png[1] == 'P');
  // Width and height stand at 16, high byte first.
  CHECK(png[18] * 256 + png[19] == 400);
  CHECK(png[22] * 256 + png[23] == 200);
}

TEST_CASE("sizes out of range are refused") {
  const TriangleMesh mesh = ball();
  const MeshDistance distance(mesh);
  for (const int size : {-1, 0, 63, 8193}) {
    CHECK_THROWS_AS(static_cast<void>(draw_packing(mesh, distance, {}, {size, 200, 1e-3})),
                    std::invalid_argument);
  }
}

}  // namespace hapticd::test
