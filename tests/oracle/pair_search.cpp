// See pair_search.h.
#include "tests/oracle/pair_search.h"

#include <algorithm>
#include <utility>

namespace hapticd {

AxisOffset axis_offset(const Capsule& capsule, const Vector3& p_W, bool flat) {
  const Vector3 AB = capsule.p_B - capsule.p_A;
  const Vector3 AC = p_W - capsule.p_A;
  const double square = AB.squaredNorm();
  double lambda = square > 0.0 ? AC.dot(AB) / square : 0.0;
  if (!flat) lambda = std::clamp(lambda, 0.0, 1.0);
  return {AC - lambda * AB, lambda};
}

PairSearch::PairSearch(const ToolScene& scene) : capsules_(scene.obstacles.capsules_W) {
  for (std::size_t i = 0; i < scene.tool.leaf_r.size(); ++i) {
    tool_spheres_.push_back(scene.tool.leaf(static_cast<std::int32_t>(i)));
  }
  tool_groups_ = group_spheres(tool_spheres_);
  for (const BodyView& body : scene.obstacles.bodies) {
    std::vector<Sphere> spheres_W;
    for (std::size_t i = 0; i < body.tree.leaf_r.size(); ++i) {
      const Sphere leaf = body.tree.leaf(static_cast<std::int32_t>(i));
      spheres_W.push_back({transform(body.X_WB, leaf.p), leaf.r});
    }
    bodies_.push_back(std::make_unique<SphereGrid>(std::move(spheres_W)));
  }
}

std::vector<OverlappingPair> PairSearch::find(const Pose& X, const CapsuleEnds& ends,
                                              std::span<const double> growth) {
  std::vector<OverlappingPair> pairs;
  const auto is_far = [&](const Sphere& ball_W) {
    for (std::size_t k = 0; k < capsules_.size(); ++k) {
      const AxisOffset axis = axis_offset(capsules_[k], ball_W.p, ends.flat);
      if (axis.offset_W.norm() <= ball_W.r + capsules_[k].r + growth[k]) return false;
    }
    return std::all_of(bodies_.begin(), bodies_.end(),
                       [&](const auto& body) { return body->nothing_near(ball_W.p, ball_W.r); });
  };
  visit_spheres(tool_groups_, X, is_far, [&](std::size_t i) {
    const Vector3 p_W = transform(X, tool_spheres_[i].p);
    const double r = tool_spheres_[i].r;
    for (std::size_t k = 0; k < capsules_.size(); ++k) {
      const AxisOffset axis = axis_offset(capsules_[k], p_W, ends.flat);
      const double radii = r + capsules_[k].r + growth[k];
      const double depth = radii - axis.offset_W.norm();
      const bool beside = axis.lambda >= -ends.margin && axis.lambda <= 1.0 + ends.margin;
      if (depth < 0.0 || !beside) continue;
      pairs.push_back({ObstacleKind::kCapsule, k, i, 0, axis.lambda, radii, depth});
    }
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      std::vector<std::size_t> near;
      const std::vector<Sphere>& spheres = bodies_[body]->spheres();
      bodies_[body]->visit_near(p_W, r, [&](std::size_t j) {
        const double radii = r + spheres[j].r;
        if ((p_W - spheres[j].p).squaredNorm() <= radii * radii) near.push_back(j);
      });
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      for (const std::size_t j : near) {
        const double radii = r + spheres[j].r;
        pairs.push_back(
            {ObstacleKind::kBody, body, i, j, 0.0, radii, radii - (p_W - spheres[j].p).norm()});
      }
    }
  });
  return pairs;
}

}  // namespace hapticd
