// See study_gesture.h.
#include "tests/oracle/study_gesture.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "server/model/packing/counter_random.h"
#include "tests/oracle/scene_objects.h"

namespace hapticd {
namespace {

/// How far off the surface a gesture begins and ends, m.
constexpr double kClearance = 2e-3;
/// Shares of the time in which it comes and goes.
constexpr double kComing = 0.25;
constexpr double kGoing = 0.8;
/// Depths, m: from a touch to the deepest press of a hand.
constexpr double kMinDepth = 0.5e-3;
constexpr double kMaxDepth = 6e-3;
/// Slides go to and fro so often, Hz.
constexpr double kSlowest_hz = 1.5;
constexpr double kFastest_hz = 4.0;
/// Largest rotation, rad, and the lever that makes a speed of it, m.
constexpr double kMaxTurn = 0.3;
constexpr double kTurnLever = 0.05;
/// The tool is turned out of its first orientation by at most this, rad.
constexpr double kTilt = 0.2;
/// On a string or line, the share of the slide that leads off it.
constexpr double kStray = 0.05;
/// Places tried before a scene is given up.
constexpr int kTries = 200;
/// The tool comes from so far, m, and stops where nothing is nearer than kTouch, m.
constexpr double kApproach = 0.06;
constexpr double kTouch = 50e-6;

/// Numbers of one seed, one after the other.
class Numbers {
 public:
  Numbers(std::uint64_t seed, double speed)
      : stream_(scrambled(seed) ^ static_cast<std::uint64_t>(std::llround(1e6 * speed))) {}

  double uniform() { return counter_uniform(stream_, index_++); }
  double between(double a, double b) { return a + (b - a) * uniform(); }
  std::size_t choice(std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(uniform() * static_cast<double>(count)));
  }
  Vector3 direction() {
    const Vector3 d = counter_direction(stream_ + 1, index_);
    ++index_;
    return d;
  }

 private:
  std::uint64_t stream_;
  std::uint64_t index_ = 0;
};

double smooth_step(double x) {
  const double s = std::clamp(x, 0.0, 1.0);
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

double sine(double hz, double t) { return sin_cos(2.0 * kPi * hz * t).sin; }

/// Where a tool comes to, and from where.
struct Place {
  Vector3 p_W;
  Vector3 n_W;
  Vector3 axis_W{0.0, 0.0, 0.0};  ///< of a capsule, not normalised: slides go along it mostly
};

/// A place on the axis of a capsule or the surface of a body's sphere, and a way there.
Place choose_place(const ToolScene& view, const SceneObjects& objects, const Vector3& start,
                   Numbers& numbers) {
  const std::size_t object = numbers.choice(objects.names.size());
  const auto from = [&](const Vector3& p) {
    const Vector3 n = (start - p).normalized() + 0.4 * numbers.direction();
    return Vector3(n.normalized());
  };
  for (std::size_t body = 0; body < objects.of_body.size(); ++body) {
    if (objects.of_body[body] != object) continue;
    const BodyView& view_of = view.obstacles.bodies[body];
    const std::size_t leaf = numbers.choice(view_of.tree.leaf_r.size());
    const Sphere sphere = view_of.tree.leaf(static_cast<std::int32_t>(leaf));
    const Vector3 centre = transform(view_of.X_WB, sphere.p);
    const Vector3 n = from(centre);
    return {centre + sphere.r * n, n};
  }
  std::vector<std::size_t> pieces;
  for (std::size_t c = 0; c < objects.of_capsule.size(); ++c) {
    if (objects.of_capsule[c] == object) pieces.push_back(c);
  }
  const Capsule& capsule = view.obstacles.capsules_W[pieces[numbers.choice(pieces.size())]];
  const Vector3 axis = capsule.p_B - capsule.p_A;
  const Vector3 p = capsule.p_A + numbers.between(0.05, 0.95) * axis;
  Vector3 n = from(p);
  if (axis.norm() > 0.0) n -= n.dot(axis) / axis.squaredNorm() * axis;
  return {p, n.norm() > 1e-3 ? Vector3(n.normalized()) : Vector3(0.0, 1.0, 0.0), axis};
}

/// Centre of the tool's leaf that reaches farthest along `d_G`, in G.
Vector3 foremost(const SphereTreeView& tool, const Vector3& d_G) {
  Vector3 best = Vector3::Zero();
  double farthest = -1.0;
  for (std::size_t i = 0; i < tool.leaf_r.size(); ++i) {
    const Sphere leaf = tool.leaf(static_cast<std::int32_t>(i));
    const double reach = leaf.p.dot(d_G) + leaf.r;
    if (i > 0 && reach <= farthest) continue;
    farthest = reach;
    best = leaf.p;
  }
  return best;
}

double smallest(const ObstacleGaps& gaps) {
  double gap = kFarthestGap;
  for (const double each : gaps.capsules) gap = std::min(gap, each);
  for (const double each : gaps.bodies) gap = std::min(gap, each);
  return gap;
}

/// Leads the tool along -n until it touches; none when it begins inside something, or never does.
std::optional<Pose> touch(PathJudge& judge, const Quaternion& q, const Vector3& p_end,
                          const Vector3& n_W) {
  ContactState state;
  state.X_WG.q = q;
  for (double left = kApproach; left > -kApproach;) {
    state.X_WG.p = p_end + left * n_W;
    const double gap = smallest(judge.gaps(state));
    if (gap < 0.0) return std::nullopt;
    if (gap < kTouch) return state.X_WG;
    left -= std::max(gap, 0.5 * kTouch);
  }
  return std::nullopt;
}

void draw_motion(double speed, const Vector3& axis_W, Numbers& numbers, StudyGesture& gesture) {
  const double share = numbers.uniform();
  gesture.depth = kMinDepth * exponential(share * logarithm(kMaxDepth / kMinDepth));
  gesture.slide_hz = numbers.between(kSlowest_hz, kFastest_hz);
  gesture.cross_hz = numbers.between(0.5, 1.0) * kSlowest_hz;
  gesture.turn_hz = numbers.between(kSlowest_hz, kFastest_hz);
  const bool line = axis_W.norm() > 0.0;
  const Vector3 random = numbers.direction();
  const Vector3 d = line ? Vector3(axis_W.normalized() + kStray * random) : random;
  const Vector3 along = (d - d.dot(gesture.n_W) * gesture.n_W).normalized();
  gesture.slide_W = speed / (2.0 * kPi * gesture.slide_hz) * along;
  gesture.cross_W =
      (line ? kStray : 0.3) * speed / (2.0 * kPi * gesture.cross_hz) * gesture.n_W.cross(along);
  const double turn = speed / kTurnLever / (2.0 * kPi * gesture.turn_hz);
  gesture.turn_W = std::min(turn, kMaxTurn) * numbers.direction();
}

}  // namespace

Pose StudyGesture::at(double t) const {
  const double at_t = std::clamp(t, 0.0, kStudyGesture_s);
  const double share = at_t / kStudyGesture_s;
  const double pressed =
      smooth_step(share / kComing) - smooth_step((share - kGoing) / (1 - kGoing));
  Pose X_WH = X_WH_touch;
  X_WH.p += (kClearance - pressed * (kClearance + depth)) * n_W;
  X_WH.p += sine(slide_hz, at_t) * slide_W + sine(cross_hz, at_t) * cross_W;
  X_WH.q = renormalised(exp_rotation(sine(turn_hz, at_t) * turn_W) * X_WH_touch.q);
  return X_WH;
}

StudyGesture choose_study_gesture(const Scene& scene, std::size_t tool, PathJudge& judge,
                                  std::uint64_t seed, double speed) {
  const ToolScene view = scene.tool_scene(tool);
  const SceneObjects objects = scene_objects(scene);
  const Pose& start = scene.description().tools[tool].X_WG;
  Numbers numbers(seed, speed);
  for (int tried = 0; tried < kTries && !objects.names.empty(); ++tried) {
    StudyGesture gesture;
    const Place place = choose_place(view, objects, start.p, numbers);
    const Quaternion q =
        renormalised(exp_rotation(kTilt * numbers.uniform() * numbers.direction()) * start.q);
    const Vector3 front = q * foremost(view.tool, q.conjugate() * Vector3(-place.n_W));
    gesture.n_W = place.n_W;
    draw_motion(speed, place.axis_W, numbers, gesture);
    const std::optional<Pose> touched = touch(judge, q, place.p_W - front, place.n_W);
    if (!touched) continue;
    gesture.X_WH_touch = *touched;
    ContactState begin;
    begin.X_WG = gesture.at(0.0);
    if (smallest(judge.gaps(begin)) > kTouch) return gesture;
  }
  throw std::runtime_error("the scene " + scene.description().name +
                           " has no place that its tool can come to. Choose another scene");
}

}  // namespace hapticd
