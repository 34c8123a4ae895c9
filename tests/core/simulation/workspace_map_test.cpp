// Truth: the equations with 3x3 matrices in long double, virtual work, and what clutch and recentre
// mean: nothing jumps, and home is home.
#include "core/simulation/workspace_map.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/math/rotation.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using Long3 = Eigen::Matrix<long double, 3, 1>;
using LongMatrix = Eigen::Matrix<long double, 3, 3>;

Quaternion random_quaternion(SplitMix64& random) {
  return exp_rotation(to_vector(random.direction()) * random.uniform(0.0, 3.1));
}

Pose random_pose(SplitMix64& random, double size) {
  return {random_quaternion(random), to_vector(random.direction()) * (size * random.uniform())};
}

Twist random_twist(SplitMix64& random) {
  return {to_vector(random.direction()) * random.uniform(), to_vector(random.direction())};
}

WorkspaceMap random_map(SplitMix64& random) {
  WorkspaceMap map;
  map.scale = std::pow(10.0, random.uniform(-2.0, 2.0));
  map.X_WD = random_pose(random, 2.0);
  map.mirror = static_cast<Mirror>(random.below(3));
  return map;
}

LongMatrix mirror_matrix(Mirror mirror) {
  LongMatrix M = LongMatrix::Identity();
  if (mirror == Mirror::kX) M(0, 0) = -1.0L;
  if (mirror == Mirror::kZ) M(2, 2) = -1.0L;
  return M;
}

LongMatrix matrix_of(const Quaternion& q) {
  return q.cast<long double>().normalized().toRotationMatrix();
}

double distance(const Pose& a, const Pose& b) {
  return (a.p - b.p).norm() + log_rotation(renormalised(a.q * b.q.conjugate())).norm();
}

}  // namespace

TEST_CASE("poses, twists and wrenches are those of the equations, mirrored or not") {
  SplitMix64 random(81);
  for (std::int64_t i = 0; i < scaled(200'000); ++i) {
    const WorkspaceMap map = random_map(random);
    const Pose X_DH = random_pose(random, 0.3);
    const Twist V = random_twist(random);
    const LongMatrix M = mirror_matrix(map.mirror);
    const LongMatrix R_WD = matrix_of(map.X_WD.q);
    const Pose X_WH = to_world(map, WorkspaceState{}, X_DH);
    const Long3 p =
        M * (map.X_WD.p.cast<long double>() + map.scale * (R_WD * X_DH.p.cast<long double>()));
    const LongMatrix R = M * R_WD * matrix_of(X_DH.q) * M;
    REQUIRE((X_WH.p.cast<long double>() - p).norm() <= 1e-14L * (1.0L + p.norm()));
    REQUIRE((matrix_of(X_WH.q) - R).norm() <= 1e-14L);
    REQUIRE(static_cast<double>(R.determinant()) == doctest::Approx(1.0));
    // The derivative of the equations: v = M scale R_WD v_D, [w]x = R' R^T.
    const Twist V_W = to_world(map, V);
    REQUIRE(
        (V_W.v.cast<long double>() - M * (map.scale * (R_WD * V.v.cast<long double>()))).norm() <=
        1e-13L);
    LongMatrix spin;
    const Long3 w = V.w.cast<long double>();
    spin << 0.0L, -w.z(), w.y(), w.z(), 0.0L, -w.x(), -w.y(), w.x(), 0.0L;
    const LongMatrix spin_W = M * R_WD * spin * matrix_of(X_DH.q) * M * R.transpose();
    const Long3 w_W(spin_W(2, 1), spin_W(0, 2), spin_W(1, 0));
    REQUIRE((V_W.w.cast<long double>() - w_W).norm() <= 1e-13L);
  }
}

TEST_CASE("there and back is where one was, at every scale, wherever the hand was brought") {
  SplitMix64 random(82);
  for (std::int64_t i = 0; i < scaled(200'000); ++i) {
    const WorkspaceMap map = random_map(random);
    WorkspaceState state;
    WorkspaceInput recentre;
    recentre.X_DH = random_pose(random, 0.3);
    recentre.recentre = random.chance(0.5);
    (void)place(map, random_pose(random, 1.0), recentre, state);
    const Pose X_DH = random_pose(random, 0.3);
    REQUIRE(distance(to_device(map, state, to_world(map, state, X_DH)), X_DH) <=
            1e-14 * (1.0 + 8.0 / map.scale));
    const Twist V = random_twist(random);
    const Twist back = to_device(map, to_world(map, V));
    REQUIRE((back.v - V.v).norm() + (back.w - V.w).norm() <= 1e-14);
    const Wrench F{V.v * 10.0, V.w};
    const Wrench F_back = to_device(map, to_world(map, F));
    REQUIRE((F_back.f - F.f).norm() + (F_back.t - F.t).norm() <= 1e-13);
  }
}

TEST_CASE("virtual work: torque does the same on both sides, force that over the scale") {
  SplitMix64 random(83);
  for (std::int64_t i = 0; i < scaled(200'000); ++i) {
    const WorkspaceMap map = random_map(random);
    const Twist V_D = random_twist(random);
    const Twist V_W = to_world(map, V_D);
    const Wrench F_W{to_vector(random.direction()) * 10.0, to_vector(random.direction())};
    const Wrench F_D = to_device(map, F_W);
    REQUIRE(F_D.f.dot(V_D.v) * map.scale == doctest::Approx(F_W.f.dot(V_W.v)));
    REQUIRE(F_D.t.dot(V_D.w) == doctest::Approx(F_W.t.dot(V_W.w)));
    REQUIRE(F_D.f.norm() == doctest::Approx(10.0));
  }
}

TEST_CASE("the clutch lets the device go on while the tool stands still, without a jump") {
  SplitMix64 random(84);
  for (std::int64_t i = 0; i < scaled(20'000); ++i) {
    WorkspaceMap map = random_map(random);
    map.clutch_button = static_cast<int>(random.below(16));
    WorkspaceState state;
    WorkspaceInput input;
    input.dt_s = 1e-3;
    input.X_DH = random_pose(random, 0.2);
    input.V_DH_D = random_twist(random);
    const Pose before = place(map, {}, input, state).X_WH;
    const bool by_button = random.chance(0.5);
    input.buttons = by_button
                        ? static_cast<std::uint16_t>(1U << static_cast<unsigned>(map.clutch_button))
                        : std::uint16_t{0};
    input.clutch_open = !by_button;
    PlacedHand out;
    for (int k = 0; k < 5; ++k) {
      out = place(map, {}, input, state);
      REQUIRE(out.open);
      REQUIRE(distance(out.X_WH, before) <= 1e-13);
      REQUIRE(out.V_WH_W.v == Vector3::Zero());
      REQUIRE(out.wrench_share == 0.0);
      input.X_DH = random_pose(random, 0.2);
    }
    input.buttons = 0;
    input.clutch_open = false;
    out = place(map, {}, input, state);
    REQUIRE(distance(out.X_WH, before) <= 1e-12 * (1.0 + map.scale));
    REQUIRE(out.wrench_share == 0.0);
    // From there on it follows: moves and turns of the device are those of the equations.
    const Pose X_DH = input.X_DH;
    input.X_DH.p += Vector3(1e-3, 2e-3, -1e-3);
    const Vector3 moved = place(map, {}, input, state).X_WH.p - out.X_WH.p;
    const Vector3 expected = to_world(map, Twist{input.X_DH.p - X_DH.p, {0, 0, 0}}).v;
    REQUIRE((moved - expected).norm() <= 1e-12 * (1.0 + map.scale));
  }
}

TEST_CASE("turning the device after recentring turns the tool about the same axis of the world") {
  SplitMix64 random(85);
  for (std::int64_t i = 0; i < scaled(20'000); ++i) {
    const WorkspaceMap map = random_map(random);
    WorkspaceState state;
    WorkspaceInput input;
    input.X_DH = random_pose(random, 0.2);
    input.recentre = true;
    const Pose home = random_pose(random, 1.0);
    const Pose first = place(map, home, input, state).X_WH;
    REQUIRE(distance(first, home) <= 1e-12 * (1.0 + map.scale));
    input.recentre = false;
    const Vector3 turn = to_vector(random.direction()) * 0.1;
    input.X_DH.q = renormalised(exp_rotation(turn) * input.X_DH.q);
    const Pose second = place(map, home, input, state).X_WH;
    const Vector3 turned = log_rotation(renormalised(second.q * first.q.conjugate()));
    REQUIRE((turned - to_world(map, Twist{{0, 0, 0}, turn}).w).norm() <= 1e-12);
  }
}

TEST_CASE("the recentre button acts when pressed, once, and not when held from the start") {
  WorkspaceMap map;
  map.recentre_button = 3;
  const Pose home{Quaternion(1, 0, 0, 0), Vector3(0, 1, 0)};
  WorkspaceState state;
  WorkspaceInput input;
  input.dt_s = 1e-3;
  input.X_DH.p = {0.1, 0, 0};
  input.buttons = 8;
  CHECK(place(map, home, input, state).X_WH.p == Vector3(0.1, 0, 0));
  input.buttons = 0;
  CHECK(place(map, home, input, state).X_WH.p == Vector3(0.1, 0, 0));
  input.buttons = 8;
  CHECK(place(map, home, input, state).X_WH.p == Vector3(0, 1, 0));
  input.X_DH.p = {0.2, 0, 0};
  CHECK((place(map, home, input, state).X_WH.p - Vector3(0.1, 1, 0)).norm() <= 1e-15);
}

TEST_CASE(
    "recentring with the clutch open brings the held tool home, and closing leaves it there") {
  WorkspaceMap map;
  const Pose home{Quaternion(1, 0, 0, 0), Vector3(0, 1, 0)};
  WorkspaceState state;
  WorkspaceInput input;
  input.X_DH.p = {0.1, 0, 0};
  input.clutch_open = true;
  (void)place(map, home, input, state);
  input.recentre = true;
  CHECK(place(map, home, input, state).X_WH.p == home.p);
  input.recentre = false;
  input.X_DH.p = {-0.3, 0.2, 0};
  CHECK(place(map, home, input, state).X_WH.p == home.p);
  input.clutch_open = false;
  CHECK((place(map, home, input, state).X_WH.p - home.p).norm() <= 1e-15);
}

TEST_CASE("the wrench comes back in 200 ms as a straight line, and a pause is no jump") {
  const WorkspaceMap map;
  WorkspaceState state;
  WorkspaceInput input;
  input.dt_s = 1e-3;
  CHECK(place(map, {}, input, state).wrench_share == 1.0);
  input.recentre = true;
  CHECK(place(map, {}, input, state).wrench_share == 0.0);
  input.recentre = false;
  for (int k = 1; k <= 100; ++k) {
    CHECK(place(map, {}, input, state).wrench_share == doctest::Approx(k / 200.0));
  }
  input.dt_s = 10.0;
  CHECK(place(map, {}, input, state).wrench_share == doctest::Approx(0.525));
  input.dt_s = std::nan("");
  CHECK(place(map, {}, input, state).wrench_share == doctest::Approx(0.525));
}

}  // namespace hapticd::test
