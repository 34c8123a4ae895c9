// One pair of primitives at a given pose of the tool. See query.h. RT: yes.
#include "core/collision/primitive_gap.h"
#include "core/collision/query.h"

namespace hapticd {
namespace {

/// Evaluates pairs at one placement of the tool; pairs of the same body in a row share its
/// matrices.
class PairEvaluator {
 public:
  PairEvaluator(const SphereTreeView& tool, const Pose& X_WG, const ObstaclesView& obstacles,
                const DisplacedParts& displaced) noexcept
      : tool_(tool), obstacles_(obstacles), displaced_(displaced), placement_(place_tool(X_WG)) {}

  [[nodiscard]] double gap(const ContactKey& key) noexcept { return pair(key, sphere_of(key)).gap; }

  [[nodiscard]] Contact contact(const ContactKey& key) noexcept {
    const Sphere sphere_G = sphere_of(key);
    const PrimitiveGap gap = pair(key, sphere_G);
    const PlacedSphere placed{rotate(placement_.R_WG, sphere_G.p), sphere_G.r, placement_.p_WG};
    if (key.kind == ObstacleKind::kBody) {
      return make_contact(key, gap, body_normal(gap, body_.R_WB), placed);
    }
    const Capsule segment = segment_of(obstacles_, key.obstacle, key.obstacle_sphere).capsule_W;
    return make_contact(key, gap, capsule_normal(gap, segment.p_B - segment.p_A), placed);
  }

 private:
  Sphere sphere_of(const ContactKey& key) const noexcept {
    Sphere sphere_G = tree_sphere(tool_, key.tool_sphere);
    if (displaced_.parts.empty()) return sphere_G;
    const int k = displaced_.find(key.tool_sphere);
    if (k >= 0) sphere_G.p += displaced_.parts[static_cast<std::size_t>(k)].v_G;
    return sphere_G;
  }

  PrimitiveGap pair(const ContactKey& key, const Sphere& sphere_G) noexcept {
    const auto obstacle = static_cast<std::size_t>(key.obstacle);
    if (key.kind == ObstacleKind::kCapsule) {
      const AxisSegment segment = segment_of(obstacles_, key.obstacle, key.obstacle_sphere);
      const PlacedCapsule capsule = place_capsule(segment.capsule_W, placement_.p_WG);
      PrimitiveGap gap = gap_to_capsule(rotate(placement_.R_WG, sphere_G.p), sphere_G.r, capsule);
      gap.lambda = string_lambda(segment, gap.lambda);
      return gap;
    }
    const BodyView& view = obstacles_.bodies[obstacle];
    if (body_index_ != key.obstacle) {
      body_ = place_body(view.X_WB, placement_);
      body_index_ = key.obstacle;
    }
    return gap_to_body_sphere(to_body(body_, sphere_G.p), sphere_G.r,
                              tree_sphere(view.tree, key.obstacle_sphere));
  }

  const SphereTreeView& tool_;
  const ObstaclesView& obstacles_;
  const DisplacedParts& displaced_;
  const ToolPlacement placement_;
  PlacedBody body_;
  std::int32_t body_index_ = -1;
};

}  // namespace

Contact evaluate_contact(const ContactKey& key, const SphereTreeView& tool, const Pose& X_WG,
                         const ObstaclesView& obstacles, const DisplacedParts& displaced) noexcept {
  return PairEvaluator(tool, X_WG, obstacles, displaced).contact(key);
}

void evaluate_contacts(const SphereTreeView& tool, const Pose& X_WG, const ObstaclesView& obstacles,
                       ContactSet& contacts, const DisplacedParts& displaced) noexcept {
  PairEvaluator evaluator(tool, X_WG, obstacles, displaced);
  double minimum = std::numeric_limits<double>::infinity();
  for (Contact& contact : contacts.contacts) {
    contact = evaluator.contact(contact.key);
    minimum = contact.gap < minimum ? contact.gap : minimum;
  }
  contacts.minimum_gap = minimum;
}

double minimum_gap_of(const ContactSet& contacts, const SphereTreeView& tool, const Pose& X_WG,
                      const ObstaclesView& obstacles, const DisplacedParts& displaced) noexcept {
  PairEvaluator evaluator(tool, X_WG, obstacles, displaced);
  double minimum = std::numeric_limits<double>::infinity();
  for (const Contact& contact : contacts.contacts) {
    const double gap = evaluator.gap(contact.key);
    minimum = gap < minimum ? gap : minimum;
  }
  return minimum;
}

}  // namespace hapticd
