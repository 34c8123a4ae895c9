// A coupling whose axes differ, against its potential in long double with a rotation vector of its
// own, and in contact against closed forms, against the same scene seen from another frame, and
// against the work over closed ways.
#include "core/contact/coupling_axes.h"

#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

using Long = long double;
using LongMatrix = Eigen::Matrix<Long, 3, 3>;
using LongVector = Eigen::Matrix<Long, 3, 1>;

constexpr double kTip = 0.005;
/// What a lap may give, J.
constexpr double kClosed = 10e-6;

std::uint64_t new_seed() {
  const std::uint64_t seed = std::random_device{}();
  MESSAGE("seed " << seed);
  return seed;
}

LongMatrix turned_by(const LongVector& w) {
  const Long angle = w.norm();
  if (angle == 0.0L) return LongMatrix::Identity();
  return Eigen::AngleAxis<Long>(angle, w / angle).toRotationMatrix();
}

/// Rotation vector by the trace and the skew part: |result| < pi - 1e-3.
LongVector rotation_vector(const LongMatrix& R) {
  const LongVector skew(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const Long twice_sine = skew.norm();
  if (twice_sine < 1e-12L) return 0.5L * skew;
  return std::atan2(0.5L * twice_sine, 0.5L * (R.trace() - 1.0L)) / twice_sine * skew;
}

struct LongPose {
  LongMatrix R;
  LongVector p;
};

LongPose to_long(const Pose& X) {
  return {X.q.cast<Long>().normalized().toRotationMatrix(), X.p.cast<Long>()};
}

Long potential(const Vector3& along, const Vector3& about, const LongPose& X_WH,
               const LongPose& X_WG) {
  const LongVector dp = X_WH.p - X_WG.p;
  const LongVector phi = rotation_vector(X_WG.R.transpose() * X_WH.R);
  return 0.5L * (dp.dot(along.cast<Long>().cwiseProduct(dp)) +
                 phi.dot(about.cast<Long>().cwiseProduct(phi)));
}

LongPose moved_by(const LongPose& X, int k, Long step) {
  LongVector d = LongVector::Zero();
  d[k % 3] = step;
  if (k < 3) return {X.R, X.p + d};
  return {turned_by(d) * X.R, X.p};
}

/// Minus the derivative of the potential by the pose of the hand (or of G).
Eigen::Matrix<double, 6, 1> downhill(const Vector3& along, const Vector3& about, const Pose& X_WH,
                                     const Pose& X_WG, bool of_hand) {
  constexpr Long kStep = 1e-6L;
  Eigen::Matrix<double, 6, 1> out;
  const LongPose H = to_long(X_WH);
  const LongPose G = to_long(X_WG);
  for (int k = 0; k < 6; ++k) {
    const auto at = [&](Long step) {
      return of_hand ? potential(along, about, moved_by(H, k, step), G)
                     : potential(along, about, H, moved_by(G, k, step));
    };
    out[k] = static_cast<double>((at(-kStep) - at(kStep)) / (2.0L * kStep));
  }
  return out;
}

/// Numbers whose ratios are up to 1000, in proportion to `size`.
Vector3 uneven(SplitMix64& random, double size) {
  Vector3 k;
  for (Eigen::Index i = 0; i < 3; ++i) k[i] = size * std::pow(10.0, random.uniform(-1.5, 1.5));
  return k;
}

Pose any_pose(SplitMix64& random, double turn) {
  return pose_at(0.05 * to_vector(random.direction()),
                 random.uniform(0.0, turn) * to_vector(random.direction()));
}

constexpr double kHeight = kTip + 2e-3;

/// For a bar of two tips, so that both forces and torques work.
RenderingScene bar_on_line_and_ball() {
  RenderingScene scene({{{0.03, 0.0, 0.0}, kTip}, {{-0.02, 0.0, 0.01}, kTip}});
  scene.capsules_W = {{{0.03, 0.0, -0.5}, {0.03, 0.0, 0.5}, 4e-3}};
  scene.add_body({{{-0.02, -0.03, 0.01}, 0.03}}, Pose{});
  return scene;
}

/// A closed way of a hand that presses by a few newtons and turns by what gives 0.1 N m.
class RoundTrip {
 public:
  static constexpr int kTicks = 1500;

  RoundTrip(const CouplingStiffness& stiffness, SplitMix64& random)
      : turn_(std::min(0.1, 0.1 / stiffness.kr()) * to_vector(random.direction())),
        across_(turn_.norm() * to_vector(random.direction())),
        way_(std::min(1e-3, 4.0 / stiffness.kt) * to_vector(random.direction())),
        deep_(std::min(1.5e-3, 4.0 / stiffness.kt)) {}

  [[nodiscard]] Pose hand(int i) const {
    const double a = 2.0 * kPi * i / kTicks;
    return pose_at(Vector3(0.0, kHeight - deep_, 0.0) + std::cos(a) * way_ +
                       std::sin(2.0 * a) * Vector3(way_.z(), way_.x(), way_.y()),
                   std::cos(a) * turn_ + std::sin(a) * across_);
  }

 private:
  Vector3 turn_;
  Vector3 across_;
  Vector3 way_;
  double deep_;
};

struct Lap {
  double gained = 0.0;  ///< by the hand, J
  double moved = 0.0;   ///< sum of what went either way, J
  bool let_go = false;  ///< the tool leapt
  long double smallest_gap = 1.0L;
};

Lap go_round(const RoundTrip& trip, ToolRun& run) {
  Lap lap;
  for (int i = 1; i <= RoundTrip::kTicks; ++i) {
    const Wrench before = run.state.F_H_W;
    const Vector3 p_WG = run.state.X_WG.p;
    const Pose from = trip.hand(i - 1);
    const Pose to = trip.hand(i);
    run.tick(to);
    const Vector3 turned = log_rotation(to.q * from.q.conjugate());
    const double work = 0.5 * ((before.f + run.state.F_H_W.f).dot(to.p - from.p) +
                               (before.t + run.state.F_H_W.t).dot(turned));
    lap.gained += work;
    lap.moved += std::abs(work);
    const double way = (to.p - from.p).norm() + 0.1 * turned.norm();
    lap.let_go = lap.let_go || (run.state.X_WG.p - p_WG).norm() > 4.0 * way + 20e-6;
    lap.smallest_gap = std::min(lap.smallest_gap, run.scene.true_gap(run.state.X_WG));
  }
  return lap;
}

}  // namespace

TEST_CASE("hand and tool feel minus the gradient of one potential, turned by anything") {
  SplitMix64 random(new_seed());
  double worst = 0.0;
  for (std::int64_t k = 0; k < scaled(20000); ++k) {
    const Vector3 along = uneven(random, 1000.0);
    const Vector3 about = uneven(random, 1.0);
    const Pose X_WH = any_pose(random, 3.0);
    const double turn = random.chance(0.3) ? 0.3 : 3.0;
    const Pose X_WG{renormalised(any_pose(random, turn).q * X_WH.q), any_pose(random, 1.0).p};
    const PoseError error = coupling_error(X_WG, X_WH, Vector3::Zero());
    if (error.dtheta.norm() > 3.1) continue;
    const CouplingStiffness stiffness = coupling_of_axes(along, about);
    const Wrench pull = coupling_pull(stiffness, X_WH.q, error);
    Eigen::Matrix<double, 6, 1> on_G;
    on_G << pull.f, pull.t;
    const double scale = std::max(pull.f.norm(), pull.t.norm()) + 1e-3;
    worst = std::max(worst, (on_G - downhill(along, about, X_WH, X_WG, false)).norm() / scale);
    worst = std::max(worst, (on_G + downhill(along, about, X_WH, X_WG, true)).norm() / scale);
    const double U = coupling_energy(stiffness, X_WH.q, error);
    const Long truth = potential(along, about, to_long(X_WH), to_long(X_WG));
    REQUIRE(std::abs(U - static_cast<double>(truth)) <= 1e-12 * U);
    // What holds G there has the energy that is stored.
    REQUIRE(energy_under(stiffness, X_WH.q, error, {-pull.f, -pull.t}) == within(U, 1e-9));
  }
  MESSAGE("worst " << worst);
  CHECK(worst < 1e-6);
}

TEST_CASE("the units of rotation and what is beyond them give the second derivatives") {
  SplitMix64 random(new_seed());
  constexpr Long kStep = 1e-4L;
  for (std::int64_t k = 0; k < scaled(500); ++k) {
    const Vector3 about = uneven(random, 1.0);
    const Pose X_WH = any_pose(random, 3.0);
    const Pose X_WG{
        renormalised(exp_rotation(random.uniform(0.0, 3.0) * to_vector(random.direction())) *
                     X_WH.q),
        X_WH.p};
    const CouplingStiffness stiffness = coupling_of_axes({1000, 1000, 1000}, about);
    const PoseError error = coupling_error(X_WG, X_WH, Vector3::Zero());
    if (error.dtheta.norm() > 3.0) continue;
    const RotationUnits units = rotation_units(stiffness, X_WH.q, error);
    CHECK((units.T * units.inverse - Matrix3::Identity()).norm() < 1e-9);
    const Matrix3 H =
        units.inverse.transpose() * (Matrix3::Identity() + units.beyond) * units.inverse;
    const LongPose at = to_long(X_WG);
    const auto U = [&](const LongVector& d) {
      return potential({1, 1, 1}, about, to_long(X_WH), {turned_by(d) * at.R, at.p});
    };
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const LongVector a = kStep * LongVector::Unit(i);
        const LongVector b = kStep * LongVector::Unit(j);
        const Long second = (U(a + b) - U(a - b) - U(b - a) + U(-a - b)) / (4.0L * kStep * kStep);
        CHECK(std::abs(H(i, j) - static_cast<double>(second)) < 1e-5 * about.maxCoeff());
      }
    }
    const double stiffest = Eigen::SelfAdjointEigenSolver<Matrix3>(H).eigenvalues().maxCoeff();
    CHECK(stiffest <= stiffest_rotation(stiffness) * (1.0 + 1e-9));
  }
}

TEST_CASE("six numbers that are alike are one stiffness and one length, to the bit") {
  SplitMix64 random(new_seed());
  for (int k = 0; k < 10000; ++k) {
    const CouplingStiffness one{std::pow(10.0, random.uniform(-3.0, 9.0)),
                                std::pow(10.0, random.uniform(-2.5, 0.0))};
    const double kr = one.kr();
    const CouplingStiffness six = coupling_of_axes({one.kt, one.kt, one.kt}, {kr, kr, kr});
    REQUIRE_FALSE(six.per_axis);
    REQUIRE(six.kt == one.kt);
    REQUIRE(six.kr() == kr);
  }
}

TEST_CASE("a wall is felt with what the axes give along its normal, 1 N/m beside 1e5 N/m") {
  SplitMix64 random(new_seed());
  double worst = 0.0;
  for (std::int64_t k = 0; k < scaled(300); ++k) {
    const Vector3 n = to_vector(random.direction());
    RenderingScene scene({{Vector3::Zero(), kTip}});
    scene.add_body({{-1e4 * n, 1e4}}, Pose{});
    Vector3 along = uneven(random, 1000.0);
    if (random.chance(0.3)) along = {1.0, 1e5, 300.0};
    ToolRun run(scene, pose_at(0.02 * n));
    run.stiffness = coupling_of_axes(along, uneven(random, 1.0));
    const double depth = random.uniform(1e-4, 3e-3);
    run.hold(pose_at((kTip - depth) * n), 60);
    CHECK(scene.true_gap(run.state.X_WG) >= -1e-12L);
    const double k_n = 1.0 / n.dot(n.cwiseQuotient(along));
    const double force = k_n * depth;
    // The wall is a ball of 10 km: the tool slides along it by up to 1e5 times the depth.
    const double slid = (run.state.X_WG.p - kTip * n).norm();
    const double bent = slid * slid / 2e4;
    const double error = (run.state.F_H_W.f - force * n).norm();
    worst = std::max(worst, error / force);
    CHECK(error <= 1e-3 * force + 2.0 * k_n * bent + force * slid / 1e4);
  }
  MESSAGE("worst " << worst);
}

TEST_CASE("closed ways of a hand with uneven axes gain no energy, and lose none but by a slip") {
  SplitMix64 random(new_seed());
  double worst = 0.0;
  int held = 0;
  for (std::int64_t k = 0; k < scaled(60); ++k) {
    const RenderingScene scene = bar_on_line_and_ball();
    ToolRun run(scene, pose_at({0.0, kHeight + 5e-3, 0.0}));
    run.stiffness = coupling_of_axes(uneven(random, 500.0), uneven(random, 0.5));
    const RoundTrip trip(run.stiffness, random);
    run.hold(pose_at({0.0, kHeight, 0.0}), 10);
    run.hold(trip.hand(0), 200);
    // Once round to where it comes back to after each lap, if it does.
    static_cast<void>(go_round(trip, run));
    const Vector3 p_WG = run.state.X_WG.p;
    const Lap lap = go_round(trip, run);
    CHECK(lap.smallest_gap >= -1e-9L);
    if ((run.state.X_WG.p - p_WG).norm() > 1e-5) continue;
    CHECK(lap.gained <= kClosed);
    if (lap.let_go || lap.moved < 1e-4) continue;
    ++held;
    worst = std::max(worst, std::abs(lap.gained));
    CHECK(lap.gained >= -kClosed);
  }
  MESSAGE("worst " << 1e6 * worst << " uJ of " << held << " laps that nothing slipped in");
  CHECK(held > 0);
}

}  // namespace hapticd::test
