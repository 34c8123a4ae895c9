// Eigen members must have the same size and alignment whatever -march a translation unit is built
// for: libraries built for different CPUs exchange them. Holds through EIGEN_DONT_VECTORIZE and
// EIGEN_MAX_ALIGN_BYTES=0; the bench preset builds this file for x86-64-v3, the others for the
// baseline.
#include <doctest/doctest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace {

template <typename Matrix>
constexpr bool kIsPlainDoubles = alignof(Matrix) == alignof(double) &&
                                 sizeof(Matrix) ==
                                     sizeof(double) *
                                         static_cast<std::size_t>(Matrix::SizeAtCompileTime);

}  // namespace

TEST_CASE("fixed-size Eigen matrices are laid out as plain doubles") {
  CHECK(kIsPlainDoubles<Eigen::Vector2d>);
  CHECK(kIsPlainDoubles<Eigen::Vector3d>);
  CHECK(kIsPlainDoubles<Eigen::Vector4d>);
  CHECK(kIsPlainDoubles<Eigen::Matrix<double, 6, 6>>);
  CHECK(alignof(Eigen::Quaterniond) == alignof(double));
  CHECK(alignof(Eigen::Isometry3d) == alignof(double));
}
