// See exact_statics.h.
#include "tests/truth/exact_statics.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace hapticd {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// Lengths are in mm and energies in kt mm^2 inside of the program, so that all is near 1.
constexpr double kUnit = 1e-3;
/// Pairs whose gap at the start is below this are in the program, mm; the others are looked at when
/// it is solved.
constexpr double kNear = 2.0;
/// Stiffness of the penalty in units of the coupling's, at first: where a round of multipliers does
/// not halve what the last one changed, it is multiplied by kHarder.
constexpr double kPenalty = 1e3;
constexpr double kHarder = 4.0;
constexpr int kRounds = 60;
constexpr int kNewtonSteps = 100;
/// Residuals at which the program is solved, in its units.
constexpr double kSolved = 1e-10;
/// Longest step of any unknown, mm: no string is as thin as that with a tip around it.
constexpr double kLongestStep = 0.3;
constexpr double kDifference = 1e-4;

struct Pair {
  enum class Kind { kBody, kLine, kLegA, kLegB } kind;
  std::size_t object;
  std::size_t sphere;
  bool operator==(const Pair&) const = default;
};

Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 out;
  out << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return out;
}

Matrix3 rotation_of(const Vector3& w) {
  const double angle = w.norm();
  if (angle < 1e-300) return Matrix3::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

/// J with d exp(w) = [J dw]x exp(w).
Matrix3 turn_of(const Vector3& w) {
  const double angle = w.norm();
  const Matrix3 k = cross_matrix(w);
  if (angle < 1e-4) return Matrix3::Identity() + k / 2 + k * k / 6;
  const double square = angle * angle;
  return Matrix3::Identity() + (1 - std::cos(angle)) / square * k +
         (angle - std::sin(angle)) / (square * angle) * k * k;
}

Vector3 rotation_vector(const Matrix3& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

/// Vector from the nearest point of a-b to c, and that point's share of the way.
struct Nearest {
  Vector3 offset;
  double share;
};

Nearest nearest(const Vector3& c, const Vector3& a, const Vector3& b) {
  const Vector3 way = b - a;
  const double square = way.squaredNorm();
  const double share = square > 0 ? std::clamp((c - a).dot(way) / square, 0.0, 1.0) : 0.0;
  return {c - a - share * way, share};
}

/// Energy (J) and its slope (N) of a string whose vertex is at p, and of what is in series with it.
std::pair<double, Vector3> string_energy(const StaticString& string, const Vector3& p) {
  const Vector3& a = string.straight_W.p_A;
  const Vector3 way = string.straight_W.p_B - a;
  const double length = way.norm();
  const Vector3 axis = way / length;
  const double along = (p - a).dot(axis);
  const Vector3 u = p - a - along * axis;
  const double far = u.norm();
  const auto stretch = [&](double run, double d) { return d * d / (std::hypot(run, d) + run); };
  const auto pull = [&](double d) {
    return string.tension +
           string.axial * (stretch(along, d) + stretch(length - along, d)) / length;
  };
  const auto force = [&](double d) {
    return pull(d) * (d / std::hypot(along, d) + d / std::hypot(length - along, d));
  };
  double d = far;
  if (string.compliance > 0 && far > 0) {
    double low = 0;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + d);
      (string.compliance * force(middle) < far - middle ? low : d) = middle;
    }
  }
  const double ext = stretch(along, d) + stretch(length - along, d);
  const double spring =
      string.compliance > 0 ? (far - d) * (far - d) / (2 * string.compliance) : 0.0;
  Vector3 slope =
      pull(d) * (along / std::hypot(along, d) - (length - along) / std::hypot(length - along, d)) *
      axis;
  if (far > 0) slope += force(d) / far * u;
  return {string.tension * ext + string.axial * ext * ext / (2 * length) + spring, slope};
}

/// The program for one pose of the hand. Unknowns: p_WG - p_WH, rotation vector of R_WG R_HW times
/// the coupling's length, and the way of each vertex from the start.
class Program {
 public:
  Program(const StaticScene& scene, const Pose& X_WH, const StaticPlace& start)
      : scene_(scene), p_WH_(X_WH.p), R_WH_(X_WH.q.toRotationMatrix()), base_(start.vertices_W) {
    size_ = 6 + 3 * static_cast<Eigen::Index>(scene.strings.size());
    x_ = Vector::Zero(size_);
    x_.head<3>() = (start.X_WG.p - p_WH_) / kUnit;
    x_.segment<3>(3) =
        rotation_vector(start.X_WG.q.toRotationMatrix() * R_WH_.transpose()) * scene.length / kUnit;
  }

  /// Puts x_ where it is least, whatever pairs that takes.
  void solve() {
    take_in(kNear);
    for (int repeat = 0; repeat < 20; ++repeat) {
      minimise();
      if (!take_in(-1e-7)) break;
    }
  }

  [[nodiscard]] StaticRest result() const {
    StaticRest rest;
    rest.place.X_WG.p = p_WH_ + kUnit * x_.head<3>();
    const Vector3 w = rotation_part(x_);
    rest.place.X_WG.q = Quaternion(Matrix3(rotation_of(w) * R_WH_));
    for (std::size_t k = 0; k < base_.size(); ++k) rest.place.vertices_W.push_back(vertex(x_, k));
    rest.F_H_W.f = scene_.kt * kUnit * x_.head<3>();
    rest.F_H_W.t = scene_.kt * scene_.length * scene_.length * w;
    const double newton = scene_.kt * kUnit;
    rest.unbalanced = newton * slope(x_, multipliers_).cwiseAbs().maxCoeff();
    const Spheres placed = place(x_);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const double gap = gap_of(placed, pairs_[i]);
      if (multipliers_[static_cast<Eigen::Index>(i)] * newton > 1e-6) {
        rest.complementary = std::max(rest.complementary, kUnit * std::abs(gap));
      }
    }
    each_pair([&](const Pair& pair) {
      rest.entered = std::max(rest.entered, -kUnit * gap_of(placed, pair));
    });
    return rest;
  }

 private:
  /// Spheres and vertices in W.
  struct Spheres {
    std::vector<Vector3> arms;
    Vector3 p_WG;
    std::vector<Vector3> vertices;
  };

  [[nodiscard]] Vector3 rotation_part(const Vector& at) const {
    return at.segment<3>(3) * kUnit / scene_.length;
  }
  [[nodiscard]] Vector3 vertex(const Vector& at, std::size_t k) const {
    return base_[k] + kUnit * at.segment<3>(6 + 3 * static_cast<Eigen::Index>(k));
  }
  [[nodiscard]] Spheres place(const Vector& at) const {
    Spheres placed;
    const Matrix3 R = rotation_of(rotation_part(at)) * R_WH_;
    placed.p_WG = p_WH_ + kUnit * at.head<3>();
    placed.arms.reserve(scene_.tool_G.size());
    for (const Sphere& sphere : scene_.tool_G) placed.arms.emplace_back(R * sphere.p);
    for (std::size_t k = 0; k < base_.size(); ++k) placed.vertices.push_back(vertex(at, k));
    return placed;
  }

  struct Offset {
    Vector3 offset;
    double radius;
    double vertex_share;
  };
  [[nodiscard]] Offset offset_of(const Spheres& placed, const Pair& pair) const {
    const Vector3 c = placed.p_WG + placed.arms[pair.sphere];
    if (pair.kind == Pair::Kind::kBody) {
      const Sphere& body = scene_.bodies_W[pair.object];
      return {c - body.p, body.r, 0.0};
    }
    if (pair.kind == Pair::Kind::kLine) {
      const Capsule& line = scene_.lines_W[pair.object];
      return {nearest(c, line.p_A, line.p_B).offset, line.r, 0.0};
    }
    const Capsule& string = scene_.strings[pair.object].straight_W;
    const bool first = pair.kind == Pair::Kind::kLegA;
    const Nearest found = nearest(c, first ? string.p_A : string.p_B, placed.vertices[pair.object]);
    return {found.offset, string.r, found.share};
  }
  /// mm.
  [[nodiscard]] double gap_of(const Spheres& placed, const Pair& pair) const {
    const Offset found = offset_of(placed, pair);
    return (found.offset.norm() - found.radius - scene_.tool_G[pair.sphere].r - scene_.fattening) /
           kUnit;
  }

  template <typename Each>
  void each_pair(const Each& each) const {
    for (std::size_t sphere = 0; sphere < scene_.tool_G.size(); ++sphere) {
      for (std::size_t k = 0; k < scene_.bodies_W.size(); ++k) each({Pair::Kind::kBody, k, sphere});
      for (std::size_t k = 0; k < scene_.lines_W.size(); ++k) each({Pair::Kind::kLine, k, sphere});
      for (std::size_t k = 0; k < scene_.strings.size(); ++k) {
        each({Pair::Kind::kLegA, k, sphere});
        each({Pair::Kind::kLegB, k, sphere});
      }
    }
  }

  /// Adds the pairs nearer than `range` mm; true where there was one.
  bool take_in(double range) {
    const Spheres placed = place(x_);
    const std::size_t before = pairs_.size();
    each_pair([&](const Pair& pair) {
      if (gap_of(placed, pair) < range &&
          std::find(pairs_.begin(), pairs_.end(), pair) == pairs_.end()) {
        pairs_.push_back(pair);
      }
    });
    multipliers_.conservativeResizeLike(Vector::Zero(static_cast<Eigen::Index>(pairs_.size())));
    return pairs_.size() > before;
  }

  [[nodiscard]] Vector energy_slope(const Vector& at, double* energy = nullptr) const {
    const double scale = scene_.kt * kUnit * kUnit;
    Vector out = Vector::Zero(size_);
    out.head<6>() = at.head<6>();
    double sum = 0.5 * at.head<6>().squaredNorm();
    for (std::size_t k = 0; k < base_.size(); ++k) {
      const auto [joule, newton] = string_energy(scene_.strings[k], vertex(at, k));
      sum += joule / scale;
      out.segment<3>(6 + 3 * static_cast<Eigen::Index>(k)) = newton * (kUnit / scale);
    }
    if (energy != nullptr) *energy = sum;
    return out;
  }

  /// Gaps in mm and their slopes, a column per pair.
  void look(const Vector& at, Vector& gaps, Matrix* slopes) const {
    const Spheres placed = place(at);
    const Matrix3 turn = turn_of(rotation_part(at));
    const auto count = static_cast<Eigen::Index>(pairs_.size());
    gaps.resize(count);
    if (slopes != nullptr) slopes->setZero(size_, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Pair& pair = pairs_[static_cast<std::size_t>(i)];
      const Offset found = offset_of(placed, pair);
      gaps[i] = gap_of(placed, pair);
      if (slopes == nullptr) continue;
      const Vector3 n = found.offset.normalized();
      slopes->col(i).head<3>() = n;
      slopes->col(i).segment<3>(3) =
          turn.transpose() * placed.arms[pair.sphere].cross(n) / scene_.length;
      if (found.vertex_share > 0) {
        slopes->col(i).segment<3>(6 + 3 * static_cast<Eigen::Index>(pair.object)) =
            -found.vertex_share * n;
      }
    }
  }

  /// Of the energy less the work of `forces` on the gaps.
  [[nodiscard]] Vector slope(const Vector& at, const Vector& forces) const {
    Vector gaps;
    Matrix slopes;
    look(at, gaps, &slopes);
    return energy_slope(at) - slopes * forces;
  }

  /// Multiplier of every pair at these gaps.
  [[nodiscard]] Vector forces(const Vector& gaps) const {
    return (multipliers_ - penalty_ * gaps).cwiseMax(0.0);
  }

  [[nodiscard]] double augmented(const Vector& at) const {
    double energy = 0.0;
    static_cast<void>(energy_slope(at, &energy));
    Vector gaps;
    look(at, gaps, nullptr);
    return energy + (forces(gaps).squaredNorm() - multipliers_.squaredNorm()) / (2 * penalty_);
  }

  /// Curvature of the energy and of the gaps that bear force, by central differences.
  [[nodiscard]] Matrix curvature(const Vector& bearing) const {
    Matrix out(size_, size_);
    for (Eigen::Index i = 0; i < size_; ++i) {
      Vector step = Vector::Zero(size_);
      step[i] = kDifference;
      out.col(i) = (slope(x_ + step, bearing) - slope(x_ - step, bearing)) / (2 * kDifference);
    }
    return 0.5 * (out + out.transpose());
  }

  /// One step of Newton's method on the augmented function; the largest slope before it.
  double newton_step() {
    Vector gaps;
    Matrix slopes;
    look(x_, gaps, &slopes);
    const Vector bearing = forces(gaps);
    const Vector downhill = slopes * bearing - energy_slope(x_);
    const double steepest = downhill.cwiseAbs().maxCoeff();
    if (steepest < kSolved) return steepest;
    Matrix H = curvature(bearing);
    for (Eigen::Index i = 0; i < bearing.size(); ++i) {
      if (bearing[i] > 0) H += penalty_ * slopes.col(i) * slopes.col(i).transpose();
    }
    double shift = 1e-9;
    Eigen::LLT<Matrix> factor(H + shift * Matrix::Identity(size_, size_));
    while (factor.info() != Eigen::Success) {
      shift = std::max(1e-3, 4 * shift);
      factor.compute(H + shift * Matrix::Identity(size_, size_));
    }
    Vector step = factor.solve(downhill);
    step *= std::min(1.0, kLongestStep / step.cwiseAbs().maxCoeff());
    const double before = augmented(x_);
    const double promised = step.dot(downhill);
    double fraction = 1.0;
    for (int halving = 0; halving < 40; ++halving, fraction *= 0.5) {
      const Vector tried = x_ + fraction * step;
      if (augmented(tried) <= before - 1e-4 * fraction * promised) break;
      // Rounding hides the last digits of the function; its slope still tells.
      if (promised < 1e-8 && steepness(tried) < steepest) break;
    }
    x_ += fraction * step;
    return steepest;
  }

  /// Largest slope of the augmented function.
  [[nodiscard]] double steepness(const Vector& at) const {
    Vector gaps;
    look(at, gaps, nullptr);
    return slope(at, forces(gaps)).cwiseAbs().maxCoeff();
  }

  void minimise() {
    penalty_ = kPenalty;
    double last = 1e300;
    for (int round = 0; round < kRounds; ++round) {
      for (int i = 0; i < kNewtonSteps && newton_step() >= kSolved; ++i) {
      }
      Vector gaps;
      look(x_, gaps, nullptr);
      const Vector next = forces(gaps);
      const double change =
          (next - multipliers_).size() > 0 ? (next - multipliers_).cwiseAbs().maxCoeff() : 0.0;
      multipliers_ = next;
      if (change < 1e3 * kSolved) break;
      if (change > 0.5 * last) penalty_ *= kHarder;
      last = change;
    }
  }

  const StaticScene& scene_;
  Vector3 p_WH_;
  Matrix3 R_WH_;
  std::vector<Vector3> base_;
  Eigen::Index size_;
  std::vector<Pair> pairs_;
  Vector multipliers_;
  double penalty_ = kPenalty;
  Vector x_;
};

}  // namespace

bool converged(const StaticRest& rest) noexcept {
  return rest.unbalanced < 1e-6 && rest.entered < 1e-9 && rest.complementary < 1e-9;
}

StaticPlace free_place(const StaticScene& scene, const Pose& X_WG) {
  StaticPlace place{X_WG, {}};
  for (const StaticString& string : scene.strings) {
    const Vector3& a = string.straight_W.p_A;
    const Vector3& b = string.straight_W.p_B;
    const double share = std::clamp(nearest(X_WG.p, a, b).share, 1e-6, 1 - 1e-6);
    place.vertices_W.emplace_back(a + share * (b - a));
  }
  return place;
}

StaticRest rest_from(const StaticScene& scene, const Pose& X_WH, const StaticPlace& start) {
  Program program(scene, X_WH, start);
  program.solve();
  return program.result();
}

}  // namespace hapticd
