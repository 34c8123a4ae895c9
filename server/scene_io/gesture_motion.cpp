// See gesture_motion.h.
#include "server/scene_io/gesture_motion.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation.h"
#include "device/simulated/gesture.h"

namespace hapticd {
namespace {

/// A string whose direction is nearer to the vertical than this sine is upright.
constexpr double kUpright = 1e-6;
/// A way shorter than this takes no time at any speed, m.
constexpr double kNoWay = 1e-12;
/// A turn smaller than this is none, rad.
constexpr double kNoTurn = 1e-9;

Vector3 vector_of(const google::protobuf::RepeatedField<double>& numbers, int first = 0) {
  return {numbers.Get(first), numbers.Get(first + 1), numbers.Get(first + 2)};
}

Quaternion quaternion_of(const google::protobuf::RepeatedField<double>& numbers, int first = 0) {
  return renormalised(
      {numbers.Get(first), numbers.Get(first + 1), numbers.Get(first + 2), numbers.Get(first + 3)});
}

std::int64_t nanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::floor(seconds * 1e9 + 0.5));
}

GesturePoint point_of(const Pose& X_DH) {
  return {to_array(X_DH.p), to_array(renormalised(X_DH.q))};
}

class Resolver {
 public:
  Resolver(const SceneDescription& scene, const PoseToDevice& to_device, SceneProblems& problems)
      : scene_(scene), to_device_(to_device), problems_(problems) {}

  GestureMotion track(const v1::GestureTrack& track, const std::string& path) {
    return track.has_path() ? sampled(track.path()) : legs(track, path);
  }

 private:
  GestureMotion sampled(const v1::SampledPath& path) const {
    GestureMotion motion;
    motion.rate = path.rate_hz();
    const int count = path.p_wh_m_size() / 3;
    motion.samples.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      Pose X_WH{{1.0, 0.0, 0.0, 0.0}, vector_of(path.p_wh_m(), 3 * i)};
      if (!path.q_wh().empty()) X_WH.q = quaternion_of(path.q_wh(), 4 * i);
      motion.samples.push_back(point_of(to_device_(X_WH)));
    }
    return motion;
  }

  GestureMotion legs(const v1::GestureTrack& track, const std::string& path) {
    const auto tool = std::find_if(scene_.tools.begin(), scene_.tools.end(),
                                   [&](const auto& t) { return t.tool_id == track.tool_id(); });
    Pose X_WH = tool != scene_.tools.end() ? tool->X_WG : Pose{};
    GestureMotion motion;
    motion.legs.reserve(static_cast<std::size_t>(track.waypoints_size()));
    for (int i = 0; i < track.waypoints_size(); ++i) {
      const v1::Waypoint& waypoint = track.waypoints(i);
      const std::string here = path + ".waypoints[" + std::to_string(i) + "]";
      const Pose before = X_WH;
      X_WH = target(waypoint, before, here);
      GestureLeg leg;
      leg.point = point_of(to_device_(X_WH));
      leg.duration_ns = i > 0 ? duration(waypoint, before, X_WH, here) : 0;
      leg.hold_ns = nanoseconds(waypoint.hold_s());
      leg.linear = waypoint.interpolation() == v1::INTERPOLATION_LINEAR;
      motion.legs.push_back(leg);
    }
    return motion;
  }

  Pose target(const v1::Waypoint& waypoint, const Pose& before, const std::string& path) {
    if (waypoint.has_pose_wh()) {
      return {quaternion_of(waypoint.pose_wh().q()), vector_of(waypoint.pose_wh().p_m())};
    }
    const v1::StringTarget& at = waypoint.at_string();
    if (at.string_index() >= scene_.strings.size()) {
      problems_.push_back({false, "", 0, 0, path + ".at_string.string_index",
                           "there is no string " + std::to_string(at.string_index()) +
                               " in the scene " + scene_.name,
                           "It has " + std::to_string(scene_.strings.size()) + "."});
      return before;
    }
    const StringParameters& string = scene_.strings[at.string_index()].parameters;
    const Vector3 p_WA = to_vector(string.p_WA);
    const Vector3 p_WB = to_vector(string.p_WB);
    const Vector3 p_WC = p_WA + at.lambda() * (p_WB - p_WA);
    const Quaternion q = at.q_wh().empty() ? before.q : quaternion_of(at.q_wh());
    return {q, p_WC + string_frame(p_WA, p_WB) * vector_of(at.offset_m())};
  }

  std::int64_t duration(const v1::Waypoint& waypoint, const Pose& from, const Pose& to,
                        const std::string& path) {
    if (waypoint.pace_case() == v1::Waypoint::kDurationS) {
      return nanoseconds(waypoint.duration_s());
    }
    const double way = (to.p - from.p).norm();
    if (way <= kNoWay && log_rotation(to.q * from.q.conjugate()).norm() > kNoTurn) {
      problems_.push_back({false, "", 0, 0, path + ".speed_m_per_s",
                           "the tool turns here without moving, so a speed gives it no duration",
                           "Give duration_s."});
    }
    const bool linear = waypoint.interpolation() == v1::INTERPOLATION_LINEAR;
    const double seconds = (linear ? 1.0 : kMinimumJerkPeak) * way / waypoint.speed_m_per_s();
    if (!(seconds <= kMaxMotion)) {
      problems_.push_back({false, "", 0, 0, path + ".speed_m_per_s",
                           "the path takes longer than " + std::to_string(kMaxMotion) + " s",
                           "Give a higher speed."});
      return 0;
    }
    return nanoseconds(seconds);
  }

  /// As that of duration_s, s.
  static constexpr double kMaxMotion = 3600.0;

  const SceneDescription& scene_;
  const PoseToDevice& to_device_;
  SceneProblems& problems_;
};

}  // namespace

Matrix3 string_frame(const Vector3& p_WA, const Vector3& p_WB) {
  const Vector3 x = (p_WB - p_WA).normalized();
  const Vector3 up = Vector3(0.0, 1.0, 0.0);
  const bool upright = x.cross(up).norm() < kUpright;
  const Vector3 reference = upright ? Vector3(0.0, 0.0, -1.0) : up;
  const Vector3 y = (reference - reference.dot(x) * x).normalized();
  Matrix3 frame;
  frame << x, y, x.cross(y);
  return frame;
}

MotionResult resolve_gesture(const v1::Gesture& gesture, std::uint32_t tool_id,
                             const SceneDescription& scene, const PoseToDevice& to_device) {
  MotionResult result;
  for (int i = 0; i < gesture.tracks_size(); ++i) {
    if (gesture.tracks(i).tool_id() != tool_id) continue;
    Resolver resolver(scene, to_device, result.problems);
    result.motion = resolver.track(gesture.tracks(i), "tracks[" + std::to_string(i) + "]");
  }
  if (any_fault(result.problems)) result.motion.reset();
  return result;
}

}  // namespace hapticd
