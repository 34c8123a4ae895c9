// See string_balance.h.
#include "tests/core/contact/string_balance.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation.h"

namespace hapticd::test {
namespace {

/// Pairs up to this much above the skin touch, m: the tool may stand anywhere below.
constexpr double kTouching = 0.05e-6;
/// Projected Gauss-Seidel sweeps: pairs are few, and some nearly the same.
constexpr int kSweeps = 20'000;

/// Forces along y and z, torque about x per metre of the coupling's length, two per string.
using Forces = std::vector<double>;

struct Placed {
  const BalanceScene& scene;
  const ToolRun& run;
  std::vector<Vector3> centres_W;
};

void add_push(const Placed& placed, std::size_t sphere, const Vector3& n, double share, int string,
              std::vector<Forces>& pushes) {
  Forces push(3 + 2 * placed.scene.strings.size(), 0.0);
  const double r = placed.run.scene.tool_spheres[sphere].r;
  const Vector3 arm = placed.centres_W[sphere] - r * n - placed.run.state.X_WG.p;
  push[0] = n.y();
  push[1] = n.z();
  push[2] = arm.cross(n).x() / placed.run.stiffness.length;
  if (string >= 0) {
    push[3 + 2 * static_cast<std::size_t>(string)] = -share * n.y();
    push[4 + 2 * static_cast<std::size_t>(string)] = -share * n.z();
  }
  pushes.push_back(std::move(push));
}

/// Every sphere of the tool against both legs of string `k`.
void push_of_string(const Placed& placed, std::size_t k, std::vector<Forces>& pushes) {
  const ToolRun& run = placed.run;
  const Capsule& line = run.scene.capsules_W[k];
  double lambda = 0.5;
  for (const TouchedString& hold : run.state.touched) {
    if (hold.bend.capsule == static_cast<int>(k)) lambda = hold.bend.lambda;
  }
  const Vector3 p_WP =
      line.p_A + lambda * (line.p_B - line.p_A) + deflection_of(run, static_cast<int>(k));
  for (std::size_t i = 0; i < placed.centres_W.size(); ++i) {
    for (const Vector3& end : {line.p_A, line.p_B}) {
      const Vector3 leg = p_WP - end;
      const double s =
          std::clamp((placed.centres_W[i] - end).dot(leg) / leg.squaredNorm(), 0.0, 1.0);
      const Vector3 offset = placed.centres_W[i] - (end + s * leg);
      const double gap = offset.norm() - line.r - run.scene.tool_spheres[i].r;
      if (gap > run.options.skin + kTouching) continue;
      add_push(placed, i, offset.normalized(), s, static_cast<int>(k), pushes);
    }
  }
}

void push_of_bodies(const Placed& placed, std::vector<Forces>& pushes) {
  for (const Sphere& sphere : placed.scene.body_W) {
    for (std::size_t i = 0; i < placed.centres_W.size(); ++i) {
      const Vector3 offset = placed.centres_W[i] - sphere.p;
      const double gap = offset.norm() - sphere.r - placed.run.scene.tool_spheres[i].r;
      if (gap > placed.run.options.skin + kTouching) continue;
      add_push(placed, i, offset.normalized(), 0.0, -1, pushes);
    }
  }
}

/// What is left of `pull` after the pushes, each >= 0, have taken as much of it as they can.
Forces left_over(Forces pull, const std::vector<Forces>& pushes) {
  std::vector<double> multiplier(pushes.size(), 0.0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t i = 0; i < pushes.size(); ++i) {
      double along = 0.0;
      double square = 0.0;
      for (std::size_t k = 0; k < pull.size(); ++k) {
        along += pull[k] * pushes[i][k];
        square += pushes[i][k] * pushes[i][k];
      }
      const double change = std::max(-multiplier[i], -along / square);
      multiplier[i] += change;
      for (std::size_t k = 0; k < pull.size(); ++k) pull[k] += change * pushes[i][k];
    }
  }
  return pull;
}

}  // namespace

Balance balance_of(const BalanceScene& scene, const ToolRun& run, const Pose& X_WH) {
  Placed placed{scene, run, {}};
  for (const Sphere& sphere : run.scene.tool_spheres) {
    placed.centres_W.push_back(transform(run.state.X_WG, sphere.p));
  }
  const double kt = run.stiffness.kt;
  const Vector3 e = X_WH.p - run.state.X_WG.p;
  const Vector3 phi = log_rotation(X_WH.q * run.state.X_WG.q.conjugate());
  Forces pull{kt * e.y(), kt * e.z(), run.stiffness.kr() * phi.x() / run.stiffness.length};
  Balance balance;
  std::vector<Forces> pushes;
  for (std::size_t k = 0; k < scene.strings.size(); ++k) {
    const Vector3 u = deflection_of(run, static_cast<int>(k));
    double lambda = 0.5;
    for (const TouchedString& hold : run.state.touched) {
      if (hold.bend.capsule == static_cast<int>(k)) lambda = hold.bend.lambda;
    }
    const auto f = static_cast<double>(
        vertex_spring(law_string(scene.strings[k]), lambda, u.norm(), kt).force);
    balance.string_pull.push_back(f);
    const Vector3 back = u.norm() > 0.0 ? Vector3(-f * u / u.norm()) : Vector3(Vector3::Zero());
    pull.push_back(back.y());
    pull.push_back(back.z());
    push_of_string(placed, k, pushes);
  }
  push_of_bodies(placed, pushes);
  balance.pairs = static_cast<int>(pushes.size());
  double square = 0.0;
  for (const double rest : left_over(pull, pushes)) square += rest * rest;
  balance.residual = std::sqrt(square) / std::max(kt * e.norm(), 1e-3);
  return balance;
}

}  // namespace hapticd::test
