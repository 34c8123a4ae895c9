// Descent of a ball's growth: the largest distance of its points minus the depth of its centre, a
// difference of a maximum of distances and a minimum of distances. The direction is minus the
// shortest combination of the gradients seen to matter (a small bundle method); a trial that fails
// shows another one. See packing_refinement.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/geometry/closest_point.h"
#include "server/model/packing/packing_refinement.h"
#include "server/model/packing/parallel_chunks.h"

namespace hapticd {
namespace {

/// Balls per chunk of work.
constexpr std::int64_t kBallChunk = 8;
/// First step of a move as a share of the radius of the disc a ball covers. Normal value 0.2; more
/// fails more often, less goes slowly.
constexpr double kFirstStep = 0.2;
/// Share of the scale by which a step must make the growth smaller.
constexpr double kMinGain = 1e-3;
/// Length of the shortest combination of gradients below which the step is halved: the growth
/// cannot shrink by more than this share of the step.
constexpr double kFlat = 0.05;
/// Gradients kept, and steps of the search for their shortest combination.
constexpr std::size_t kBundle = 10;
constexpr int kCombineSteps = 30;

/// Gradients of the growth that matter near the centre.
class Bundle {
 public:
  void clear() { size_ = 0; }
  void add(const Vector3& gradient) {
    if (size_ == kBundle) {
      std::copy(gradients_.begin() + 1, gradients_.end(), gradients_.begin());
      --size_;
    }
    gradients_[size_++] = gradient;
  }

  /// Shortest convex combination, about (E. G. Gilbert, "An iterative procedure for computing the
  /// minimum of a quadratic form on a convex set", SIAM J. Control 1966).
  [[nodiscard]] Vector3 shortest() const {
    Vector3 x = gradients_[size_ - 1];
    for (int step = 0; step < kCombineSteps; ++step) {
      std::size_t least = 0;
      for (std::size_t i = 1; i < size_; ++i) {
        if (gradients_[i].dot(x) < gradients_[least].dot(x)) least = i;
      }
      const Vector3 to = gradients_[least] - x;
      const double squared = to.squaredNorm();
      const double along = -x.dot(to);
      if (!(along > 1e-9) || !(squared > 0.0)) break;
      x += std::min(along / squared, 1.0) * to;
    }
    return x;
  }

 private:
  std::array<Vector3, kBundle> gradients_;
  std::size_t size_ = 0;
};

class Mover {
 public:
  Mover(const MeshDistance& distance, std::span<const Vector3> points, double scale)
      : distance_(distance), points_(points), least_gain_(kMinGain * scale) {}

  void run(Sphere& ball, int trials) {
    start_at(ball);
    const double step_unit =
        std::sqrt(std::max(2.0 * std::max(ball.r, 0.0) * growth_, 0.0)) + std::fabs(growth_);
    double step = kFirstStep * step_unit;
    for (int trial = 0; trial < trials && step > 1e-3 * step_unit; ++trial) {
      const Vector3 gradient = bundle_.shortest();
      const double slope = length(gradient);
      if (slope * step < 2.0 * least_gain_ && slope < 4.0 * kFlat && step < 0.02 * step_unit) break;
      if (slope < kFlat) {
        step *= 0.5;
        start_at(ball);
        continue;
      }
      if (!try_at(ball, ball.p - (step / slope) * gradient)) continue;
      start_at(ball);
    }
  }

 private:
  /// Forgets all gradients but that at the ball.
  void start_at(const Sphere& ball) {
    const Vector3 far = farthest(ball.p);
    growth_ = length(far - ball.p) - ball.r;
    NearestPoint nearest;
    static_cast<void>(distance_.signed_distance(ball.p, nearest));
    bundle_.clear();
    add_gradient(ball.p, far, nearest.p, ball.r < 0.0);
  }

  void add_gradient(const Vector3& p, const Vector3& far, const Vector3& near, bool outside) {
    const Vector3 deeper = outside ? Vector3(near - p) : Vector3(p - near);
    bundle_.add(unit_or_zero(p - far) - unit_or_zero(deeper));
  }

  [[nodiscard]] Vector3 farthest(const Vector3& p) const {
    double most = -1.0;
    const Vector3* found = points_.data();
    for (const Vector3& q : points_) {
      const double squared = (q - p).squaredNorm();
      if (squared > most) {
        most = squared;
        found = &q;
      }
    }
    return *found;
  }

  /// Moves the ball to `p` if that helps; otherwise learns why not.
  bool try_at(Sphere& ball, const Vector3& p) {
    const double wanted = growth_ - least_gain_;
    const Vector3 far = farthest(p);
    const double r = length(far - p);
    NearestPoint near;
    if (distance_.find_nearer(p, r - wanted, near)) {
      add_gradient(p, far, near.p, false);
      return false;
    }
    const double depth = -distance_.signed_distance(p, near);
    if (r - depth < wanted) {
      ball = {p, depth};
      return true;
    }
    add_gradient(p, far, near.p, depth < 0.0);
    return false;
  }

  const MeshDistance& distance_;
  std::span<const Vector3> points_;
  double least_gain_;
  double growth_ = 0.0;
  Bundle bundle_;
};

}  // namespace

void move_balls(const MeshDistance& distance, int trials, double scale, int threads, BallSet& set) {
  for_chunks(static_cast<std::int64_t>(set.balls.size()), kBallChunk, threads,
             [&](std::int64_t, std::int64_t begin, std::int64_t end) {
               for (std::int64_t i = begin; i < end; ++i) {
                 const auto k = static_cast<std::size_t>(i);
                 const auto first = static_cast<std::size_t>(set.first[k]);
                 const auto last = static_cast<std::size_t>(set.first[k + 1]);
                 if (first == last) continue;
                 Mover mover(distance, std::span(set.points).subspan(first, last - first), scale);
                 mover.run(set.balls[k], trials);
               }
             });
}

}  // namespace hapticd
