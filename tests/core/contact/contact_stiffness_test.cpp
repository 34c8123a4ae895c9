// The stiffness of contacts as the hand feels it, against closed forms (a wall, a corner, a string
// in series with the coupling) and against how the rendered force changes when the hand moves by a
// micrometre. Contacts are light: curvature, which K leaves out, is in proportion to the force.
#include "core/contact/contact_stiffness.h"

#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "tests/core/contact/string_law_truth.h"
#include "tests/core/contact/string_scenes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kKt = 1000.0;
/// A sphere so large that it is a plane.
constexpr double kFar = 1e4;

Sphere plane(const Vector3& normal) { return {-kFar * normal, kFar}; }

ContactStiffness stiffness_of(const ToolRun& run) {
  return contact_stiffness(run.problem->view(), run.problem->unknowns());
}

RenderingScene tip_before(const std::vector<Vector3>& normals) {
  RenderingScene scene({{Vector3::Zero(), kTipRadius}});
  for (const Vector3& n : normals) scene.add_body({plane(n)}, Pose{});
  return scene;
}

ToolRun pressed(const RenderingScene& scene, const Vector3& from, const Vector3& to) {
  ToolRun run(scene, pose_at(from));
  run.stiffness.kt = kKt;
  run.hold(pose_at(to), 20);
  return run;
}

double least_eigenvalue(const Matrix3& K) {
  return Eigen::SelfAdjointEigenSolver<Matrix3>(K).eigenvalues().minCoeff();
}

double greatest_eigenvalue(const Matrix3& K) {
  return Eigen::SelfAdjointEigenSolver<Matrix3>(K).eigenvalues().maxCoeff();
}

}  // namespace

TEST_CASE("what touches nothing has no stiffness") {
  const RenderingScene scene = tip_before({Vector3::UnitY()});
  const ToolRun run = pressed(scene, {0, 0.02, 0}, {0.001, 0.02, 0});
  CHECK(stiffness_of(run).K_W.norm() == 0.0);
  CHECK(stiffness_of(run).Kr_W.norm() == 0.0);
}

TEST_CASE("a wall has the stiffness of the coupling along its normal and none along its surface") {
  SplitMix64 random(1);
  for (int k = 0; k < 50; ++k) {
    const Vector3 n = to_vector(random.direction());
    const RenderingScene scene = tip_before({n});
    const Vector3 deep = 0.003 * n;
    const ToolRun run = pressed(scene, 0.006 * n, deep);
    const ContactStiffness K = stiffness_of(run);
    // A tip that is a sphere about its origin turns freely.
    CHECK((K.K_W - kKt * n * n.transpose()).norm() < 1e-3 * kKt);
    CHECK(K.Kr_W.norm() < 1e-9);
  }
}

TEST_CASE(
    "in a corner of two walls the stiffness is that of the coupling across both, whatever "
    "the angle") {
  for (const double angle : {0.3, 1.0, 1.5707963267948966, 2.5}) {
    const Vector3 a(std::sin(0.5 * angle), std::cos(0.5 * angle), 0.0);
    const Vector3 b(-std::sin(0.5 * angle), std::cos(0.5 * angle), 0.0);
    const RenderingScene scene = tip_before({a, b});
    const Vector3 deep(0.0, 0.002, 0.0);
    const ToolRun run = pressed(scene, {0.0, 0.03, 0.0}, deep);
    REQUIRE(run.result.active_count == 2);
    const ContactStiffness K = stiffness_of(run);
    const Matrix3 across = kKt * Vector3(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix();
    CHECK((K.K_W - across).norm() < 1e-3 * kKt);
  }
}

TEST_CASE(
    "the stiffness is how the force changes with the hand, in corners and on strings that "
    "yield") {
  SplitMix64 random(2);
  std::int64_t compared = 0;
  for (std::int64_t k = 0; k < scaled(400); ++k) {
    const RenderingScene scene =
        random.chance(0.5) ? scene_of({string_at(), string_at(0.0, 0.008)})
                           : tip_before({Vector3::UnitY(), to_vector(random.direction())});
    const double x = random.uniform(0.2, 0.9);
    const Vector3 above(x, 0.02, random.uniform(0.0, 0.008));
    // Down to a light touch.
    ToolRun run(scene, pose_at(above));
    run.stiffness.kt = kKt;
    run.options = reference_options();
    Vector3 p_WH = above;
    while (p_WH.y() > 0.0 && run.state.F_H_W.f.norm() < 2e-3) {
      p_WH.y() -= 5e-6 + 0.2 * std::max(0.0, p_WH.y() - 0.0055);
      run.hold(pose_at(p_WH), 3);
    }
    run.hold(pose_at(p_WH), 50);
    const double force = run.state.F_H_W.f.norm();
    const bool light = force > 1e-3 && force < 0.1;
    if (!light || run.result.status != ContactStatus::kConverged) continue;
    const ContactStiffness K = stiffness_of(run);
    CHECK(least_eigenvalue(K.K_W) >= -1e-9 * kKt);
    CHECK(greatest_eigenvalue(K.K_W) <= kKt * (1.0 + 1e-9));
    const Vector3 f = run.state.F_H_W.f;
    const int pairs = run.result.active_count;
    const double way = 0.02 * force / kKt;
    for (int j = 0; j < 3; ++j) {
      const Vector3 d = way * to_vector(random.direction());
      ToolRun moved(scene, run.state.X_WG);
      moved.state = run.state;
      moved.stiffness = run.stiffness;
      moved.options = run.options;
      moved.hold(pose_at(p_WH + d), 50);
      if (moved.result.active_count != pairs) continue;
      const Vector3 change = moved.state.F_H_W.f - f;
      // Curvature: the force turns by the way over the radius, and is 2 percent of the way's pull.
      const double turning = force * way / (0.8 * kTipRadius);
      CHECK((change + K.K_W * d).norm() <= 0.02 * kKt * way + turning);
      ++compared;
    }
  }
  CHECK(compared > 0);
}

}  // namespace hapticd::test
