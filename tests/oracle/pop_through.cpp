// See pop_through.h.
#include "tests/oracle/pop_through.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/oracle/pair_search.h"

namespace hapticd {
namespace {

/// Steps of the path, in s. Larger: a way just beside the axis may be taken for one around it.
constexpr double kStep = 1.0 / 16.0;
/// Steps of one tick, at most: of a teleport.
constexpr double kMaxSteps = 1e5;
/// C nearer than this share of s did not go around.
constexpr double kAround = 0.70710678118654752440;

Vector3 direction(const Vector3& offset) {
  const double length = offset.norm();
  return length > 0.0 ? Vector3(offset / length) : Vector3(0.0, 0.0, 0.0);
}

}  // namespace

PopThroughWatch::PopThroughWatch(const ToolScene& scene)
    : capsules_(scene.obstacles.capsules_W), thinnest_(std::numeric_limits<double>::infinity()) {
  for (std::size_t i = 0; i < scene.tool.leaf_r.size(); ++i) {
    const Sphere leaf = scene.tool.leaf(static_cast<std::int32_t>(i));
    tool_spheres_.push_back(leaf);
    reach_ = std::max(reach_, leaf.p.norm() + leaf.r);
    for (const Capsule& capsule : capsules_) thinnest_ = std::min(thinnest_, leaf.r + capsule.r);
  }
  tool_groups_ = group_spheres(tool_spheres_);
}

bool PopThroughWatch::follow_sphere(std::size_t capsule, std::size_t sphere,
                                    std::span<const Pose> path) {
  const double s = tool_spheres_[sphere].r + capsules_[capsule].r;
  const std::pair<std::size_t, std::size_t> key{capsule, sphere};
  bool popped = false;
  Vector3 nhat_before{0.0, 0.0, 0.0};
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Vector3 p_W = transform(path[k], tool_spheres_[sphere].p);
    const Vector3 offset_W = axis_offset(capsules_[capsule], p_W, false).offset_W;
    const double distance = offset_W.norm();
    const Vector3 nhat_W = direction(offset_W);
    const auto overlap = overlaps_.find(key);
    if (distance < s && overlap == overlaps_.end()) {
      overlaps_[key] = {k > 0 ? nhat_before : nhat_W, distance};
    } else if (distance < s) {
      overlap->second.nearest = std::min(overlap->second.nearest, distance);
    } else if (overlap != overlaps_.end()) {
      const bool other_side = overlap->second.nhat_in_W.dot(nhat_W) < 0.0;
      popped = popped || (other_side && overlap->second.nearest < kAround * s);
      overlaps_.erase(overlap);
    }
    nhat_before = nhat_W;
  }
  return popped;
}

std::vector<bool> PopThroughWatch::go(const Pose& X_WF, const Pose& X_WT) {
  std::vector<bool> popped(capsules_.size(), false);
  if (capsules_.empty()) return popped;
  const ToolStep way = coupling_error(X_WF, X_WT, Vector3::Zero());
  const double bound = displacement_bound(way, reach_);
  const double wanted = std::ceil(bound / (kStep * std::max(thinnest_, 1e-6)));
  const auto steps = static_cast<std::size_t>(std::clamp(wanted, 1.0, kMaxSteps));
  std::vector<Pose> path{X_WF};
  for (std::size_t k = 1; k < steps; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(steps);
    path.push_back(moved(X_WF, scaled(way, share)));
  }
  path.push_back(X_WT);
  for (std::size_t c = 0; c < capsules_.size(); ++c) {
    const double from_G = axis_offset(capsules_[c], X_WF.p, false).offset_W.norm();
    if (from_G > reach_ + bound + capsules_[c].r && overlaps_.empty()) continue;
    const auto is_far = [&](const Sphere& ball_W) {
      const double distance = axis_offset(capsules_[c], ball_W.p, false).offset_W.norm();
      return overlaps_.empty() && distance > ball_W.r + capsules_[c].r + bound;
    };
    visit_spheres(tool_groups_, X_WF, is_far, [&](std::size_t i) {
      const Vector3 p_W = transform(X_WF, tool_spheres_[i].p);
      const double distance = axis_offset(capsules_[c], p_W, false).offset_W.norm();
      const bool near = distance <= tool_spheres_[i].r + capsules_[c].r + bound;
      if (near || overlaps_.count({c, i}) > 0) {
        popped[c] = follow_sphere(c, i, path) || popped[c];
      }
    });
  }
  return popped;
}

}  // namespace hapticd
