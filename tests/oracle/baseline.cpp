// See baseline.h.
#include "tests/oracle/baseline.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "core/geometry/closest_point.h"
#include "core/solver/active_set.h"
#include "tests/oracle/pair_search.h"

namespace hapticd {
namespace {

/// Offsets shorter than this have no direction, m: a fixed normal is used.
constexpr double kNoDirection = 1e-12;

/// The deepest pair with a string, or with anything else.
const OverlappingPair* deepest(const std::vector<OverlappingPair>& pairs, std::size_t strings,
                               bool of_string) {
  const OverlappingPair* found = nullptr;
  for (const OverlappingPair& pair : pairs) {
    const bool is_string = pair.kind == ObstacleKind::kCapsule && pair.obstacle < strings;
    if (is_string != of_string) continue;
    if (found == nullptr || pair.depth > found->depth) found = &pair;
  }
  return found;
}

}  // namespace

class Baseline::Method {
 public:
  Method(const ToolScene& scene, const BaselineOptions& options)
      : search_(scene),
        options_(options),
        vibrations_(scene.strings.size()),
        growth_(search_.capsules(), 0.0) {}

  BaselineTick paper(const ToolScene& scene, const Pose& X_WH, double dt_s) {
    if (!placed_) X_WG_ = X_WH_ = X_WH;
    placed_ = true;
    const CapsuleEnds ends{true, options_.lambda_margin};
    std::vector<OverlappingPair> pairs = search_.find(X_WH, ends, growth_);
    BaselineTick tick;
    tick.pairs = pairs.size();
    for (const double growth : growth_) tick.radius_growth = std::max(tick.radius_growth, growth);
    tick.solved = solve(scene.stiffness, pairs, X_WH);
    tick.X_WG = X_WG_;
    render(scene, pairs, X_WH, dt_s, tick);
    X_WH_ = X_WH;
    return tick;
  }

  BaselineTick penalty(const ToolScene& scene, const Pose& X_WH) {
    std::fill(growth_.begin(), growth_.end(), 0.0);
    const std::vector<OverlappingPair> pairs = search_.find(X_WH, {}, growth_);
    BaselineTick tick;
    tick.X_WG = X_WH;
    tick.pairs = pairs.size();
    for (const OverlappingPair& pair : pairs) {
      const Vector3 p_W = transform(X_WH, search_.tool_sphere(pair.tool_sphere).p);
      const Vector3 nhat_W = normal(pair, p_W, false);
      const Vector3 f_W = scene.stiffness.kt * pair.depth * nhat_W;
      const Vector3 p_WC = p_W - search_.tool_sphere(pair.tool_sphere).r * nhat_W;
      tick.F_H_W.f += f_W;
      tick.F_H_W.t += (p_WC - X_WH.p).cross(f_W);
    }
    tick.repulsion = tick.F_H_W.f.norm();
    return tick;
  }

 private:
  /// From the obstacle's axis or centre to the centre of the tool sphere at p_W.
  [[nodiscard]] Vector3 offset(const OverlappingPair& pair, const Vector3& p_W, bool flat) const {
    if (pair.kind == ObstacleKind::kCapsule) {
      return axis_offset(search_.capsule(pair.obstacle), p_W, flat).offset_W;
    }
    return p_W - search_.body_sphere(pair.obstacle, pair.body_sphere).p;
  }

  [[nodiscard]] Vector3 normal(const OverlappingPair& pair, const Vector3& p_W, bool flat) const {
    const Vector3 offset_W = offset(pair, p_W, flat);
    const double distance = offset_W.norm();
    if (distance >= kNoDirection) return offset_W / distance;
    if (pair.kind == ObstacleKind::kBody) return fixed_normal(Vector3::Zero());
    const Capsule& capsule = search_.capsule(pair.obstacle);
    return fixed_normal(capsule.p_B - capsule.p_A);
  }

  /// Eq. 5-7 around the last G: the row of a pair is the gradient of d^2, its bound what d^2 lacks.
  bool solve(const CouplingStiffness& stiffness, std::vector<OverlappingPair>& pairs,
             const Pose& X_WH) {
    if (pairs.empty()) {
      X_WG_ = X_WH;
      return true;
    }
    if (pairs.size() > static_cast<std::size_t>(kMaxQpRows)) {
      std::sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) {
        return std::tie(b.depth, a.kind, a.obstacle, a.tool_sphere, a.body_sphere) <
               std::tie(a.depth, b.kind, b.obstacle, b.tool_sphere, b.body_sphere);
      });
      pairs.resize(kMaxQpRows);
    }
    QpProblem& problem = *problem_;
    problem.unknowns = kToolDof;
    problem.rows = static_cast<int>(pairs.size());
    const PoseError error_GH = coupling_error(X_WG_, X_WH, Vector3::Zero());
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      problem.weight[k] = stiffness.kt;
      problem.weight[k + 3] = stiffness.kr();
      problem.target[k] = error_GH.dp[axis];
      problem.target[k + 3] = error_GH.dtheta[axis];
    }
    for (std::size_t i = 0; i < pairs.size(); ++i) fill_row(pairs[i], i);
    solve_qp(problem, {}, *workspace_, *solution_);
    if (solution_->status != QpStatus::kOptimal) return false;
    const auto& x = solution_->x;
    X_WG_ = moved(X_WG_, {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
    return true;
  }

  void fill_row(const OverlappingPair& pair, std::size_t i) {
    const Vector3 p_W = transform(X_WG_, search_.tool_sphere(pair.tool_sphere).p);
    Vector3 offset_W = offset(pair, p_W, true);
    const double square = offset_W.squaredNorm();
    // On the axis the gradient vanishes: a fixed direction is used.
    if (!(square > kNoDirection * kNoDirection)) offset_W = pair.radii * normal(pair, p_W, true);
    const Vector3 linear = 2.0 * offset_W;
    const Vector3 angular = (p_W - X_WG_.p).cross(linear);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      problem_->row[k][i] = linear[axis];
      problem_->row[k + 3][i] = angular[axis];
    }
    problem_->bound[i] = pair.radii * pair.radii - square;
  }

  /// Spring, string and vibration, Eq. 8-13.
  void render(const ToolScene& scene, const std::vector<OverlappingPair>& pairs, const Pose& X_WH,
              double dt_s, BaselineTick& tick) {
    const PoseError error_GH = coupling_error(X_WG_, X_WH, Vector3::Zero());
    const double stretch = error_GH.dp.norm();
    const Vector3 nhat_W = stretch > 0.0 ? Vector3(-error_GH.dp / stretch) : Vector3(0.0, 0.0, 0.0);
    const std::size_t strings = scene.strings.size();
    const OverlappingPair* string = deepest(pairs, strings, true);
    tick.repulsion = pairs.empty() ? 0.0 : scene.stiffness.kt * stretch;
    if (string != nullptr) {
      const StringConstants& constants = scene.strings[string->obstacle];
      tick.deflection = stretch / constants.k_s;
      if (deepest(pairs, strings, false) == nullptr) {
        tick.repulsion = printed_deflection(constants, string->lambda, tick.deflection).force;
      }
    }
    tick.vibration = vibrate(scene, pairs, stretch, nhat_W.dot(X_WH.p - X_WH_.p), dt_s);
    tick.F_H_W.f = (tick.repulsion + tick.vibration) * nhat_W;
    if (!pairs.empty()) tick.F_H_W.t = -scene.stiffness.kr() * error_GH.dtheta;
  }

  /// Steps every string, and returns F_v of the touched ones.
  double vibrate(const ToolScene& scene, const std::vector<OverlappingPair>& pairs, double stretch,
                 double moved_away, double dt_s) {
    double force = 0.0;
    for (std::size_t s = 0; s < scene.strings.size(); ++s) {
      const StringConstants& string = scene.strings[s];
      const auto touches = [s](const OverlappingPair& pair) {
        return pair.kind == ObstacleKind::kCapsule && pair.obstacle == s;
      };
      const auto touch = std::find_if(pairs.begin(), pairs.end(), touches);
      const bool touched = touch != pairs.end();
      const double delta = touched ? stretch / string.k_s : -1.0;
      PrintedVibration& vibration = vibrations_[s];
      vibration.advance(string, delta, touched ? touch->lambda : 0.5, dt_s);
      if (touched) force += vibration.force(string, options_.vibration, moved_away, dt_s);
      const Breathing breathing = options_.breathing;
      growth_[s] = breathing == Breathing::kNone ? 0.0 : vibration.radius(string);
      if (breathing == Breathing::kAlways && touched) growth_[s] = std::max(growth_[s], delta);
    }
    return force;
  }

  PairSearch search_;
  BaselineOptions options_;
  std::vector<PrintedVibration> vibrations_;  ///< of the strings
  std::vector<double> growth_;                ///< r(t) of each capsule, m
  Pose X_WG_;
  Pose X_WH_;
  bool placed_ = false;
  std::unique_ptr<QpProblem> problem_ = std::make_unique<QpProblem>();
  std::unique_ptr<QpWorkspace> workspace_ = std::make_unique<QpWorkspace>();
  std::unique_ptr<QpSolution> solution_ = std::make_unique<QpSolution>();

  friend class Baseline;
};

Baseline::Baseline(const ToolScene& scene, const BaselineOptions& options)
    : method_(std::make_unique<Method>(scene, options)) {}

Baseline::~Baseline() = default;

BaselineTick Baseline::tick(const ToolScene& scene, const Pose& X_WH, double dt_s) {
  if (method_->options_.method == BaselineMethod::kPenalty) return method_->penalty(scene, X_WH);
  return method_->paper(scene, X_WH, dt_s);
}

}  // namespace hapticd
