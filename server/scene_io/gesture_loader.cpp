// See gesture_loader.h.
#include "server/scene_io/gesture_loader.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "server/scene_io/field_check.h"
#include "server/scene_io/message_text.h"
#include "server/scene_io/model_files.h"
#include "server/scene_io/named_text.h"
#include "server/scene_io/scene_defaults.h"

namespace hapticd {
namespace {

/// Squared norms of quaternions that can be normalised.
constexpr double kMinSquare = 0.25;
constexpr double kMaxSquare = 4.0;

bool is_name(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

/// Collects what the comments of the fields alone do not say.
class Check {
 public:
  void gesture(const v1::Gesture& gesture) {
    if (!is_name(gesture.name())) {
      fault("name", "'" + gesture.name() + "' is not a name for a gesture",
            "Use a to z, 0 to 9 and _ alone.");
    }
    std::set<std::uint32_t> tools;
    for (int i = 0; i < gesture.tracks_size(); ++i) {
      const std::string path = "tracks[" + std::to_string(i) + "]";
      if (!tools.insert(gesture.tracks(i).tool_id()).second) {
        fault(path + ".tool_id",
              "a second track of tool " + std::to_string(gesture.tracks(i).tool_id()),
              "Put the way-points of one tool into one track.");
      }
      track(gesture.tracks(i), path);
    }
  }
  [[nodiscard]] SceneProblems take() && { return std::move(problems_); }

 private:
  void fault(std::string path, std::string message, std::string remedy) {
    problems_.push_back({false, "", 0, 0, std::move(path), std::move(message), std::move(remedy)});
  }

  template <typename Numbers>
  void quaternion(const Numbers& q, int first, const std::string& path) {
    double square = 0.0;
    for (int k = first; k < first + 4 && k < q.size(); ++k) square += q.Get(k) * q.Get(k);
    if (q.empty() || (square >= kMinSquare && square <= kMaxSquare)) return;
    fault(path, "a quaternion of norm " + std::to_string(std::sqrt(square)),
          "Give a norm in [0.5, 2].");
  }

  void track(const v1::GestureTrack& track, const std::string& path) {
    if (track.waypoints().empty() != track.has_path()) {
      fault(path, track.has_path() ? "both way-points and a path" : "neither way-points nor a path",
            "Give one of them.");
    }
    if (track.has_path()) sampled(track.path(), path + ".path");
    for (int i = 0; i < track.waypoints_size(); ++i) {
      waypoint(track.waypoints(i), i == 0, path + ".waypoints[" + std::to_string(i) + "]");
    }
  }

  void sampled(const v1::SampledPath& sampled, const std::string& path) {
    const int count = sampled.p_wh_m_size() / 3;
    if (count < 2) fault(path + ".p_wh_m", "fewer than two samples", "");
    if (!sampled.q_wh().empty() && sampled.q_wh_size() / 4 != count) {
      fault(path + ".q_wh",
            std::to_string(sampled.q_wh_size() / 4) + " orientations for " + std::to_string(count) +
                " positions",
            "Give one for each, or none.");
    }
    for (int i = 0; i + 3 < sampled.q_wh_size(); i += 4) {
      quaternion(sampled.q_wh(), i, path + ".q_wh[" + std::to_string(i) + "]");
    }
  }

  void waypoint(const v1::Waypoint& waypoint, bool first, const std::string& path) {
    if (waypoint.target_case() == v1::Waypoint::TARGET_NOT_SET) {
      fault(path, "a way-point without a place", "Give pose_wh or at_string.");
    }
    const bool paced = waypoint.pace_case() != v1::Waypoint::PACE_NOT_SET;
    if (first && paced) {
      fault(path, "the first way-point takes no time: the gesture begins there",
            "Leave out duration_s and speed_m_per_s.");
    }
    if (!first && !paced) {
      fault(path, "the time to get here is missing", "Give duration_s or speed_m_per_s.");
    }
    quaternion(waypoint.pose_wh().q(), 0, path + ".pose_wh.q");
    quaternion(waypoint.at_string().q_wh(), 0, path + ".at_string.q_wh");
  }

  SceneProblems problems_;
};

void fill_defaults(v1::Gesture& gesture) {
  for (v1::GestureTrack& track : *gesture.mutable_tracks()) {
    for (v1::Waypoint& waypoint : *track.mutable_waypoints()) {
      if (waypoint.interpolation() == v1::INTERPOLATION_UNSPECIFIED) {
        waypoint.set_interpolation(v1::INTERPOLATION_MINIMUM_JERK);
      }
      if (waypoint.has_pose_wh()) fill_pose(*waypoint.mutable_pose_wh());
      if (waypoint.has_at_string() && waypoint.at_string().offset_m().empty()) {
        waypoint.mutable_at_string()->mutable_offset_m()->Resize(3, 0.0);
      }
    }
  }
}

GestureResult load_named(const NamedText& named) {
  if (named.problem) return {std::nullopt, {*named.problem}, true};
  return check_text(named.text, named.path.string(), "gesture", check_gesture);
}

}  // namespace

GestureFolders installed_gestures() {
  return {installed_paths().scenes.front().parent_path() / "gestures"};
}

GestureResult load_installed_gesture(const std::string& name, const GestureFolders& folders) {
  return load_named(read_installed(name, folders, "gesture", kMaxText));
}

GestureResult load_gesture(const std::string& source, const GestureFolders& folders) {
  return load_named(read_named(source, folders, "gesture", kMaxText));
}

GestureResult check_gesture(const v1::Gesture& gesture) {
  GestureResult result;
  result.problems = check_fields(gesture);
  if (!any_fault(result.problems)) {
    Check check;
    check.gesture(gesture);
    for (SceneProblem& problem : std::move(check).take()) {
      result.problems.push_back(std::move(problem));
    }
  }
  if (any_fault(result.problems)) return result;
  result.gesture = gesture;
  fill_defaults(*result.gesture);
  return result;
}

}  // namespace hapticd
