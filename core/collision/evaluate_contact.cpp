// One pair of primitives at a given pose of the tool. See query.h. RT: yes.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/collision/primitive_gap.h"
#include "core/collision/query.h"

namespace hapticd {
namespace {

/// Contacts of rigid pairs with one body at another place of the tool, many at a time: arrays, so
/// that the compiler computes several at once, each with the operations of PairEvaluator in their
/// order, hence the same bits.
class BodyBatch {
 public:
  static constexpr std::size_t kCapacity = 64;

  void add(Contact& contact, const Sphere& sphere_G, const Sphere& sphere_B) noexcept {
    const std::size_t j = count_++;
    contact_[j] = &contact;
    set(p_GC_, j, sphere_G.p);
    set(p_B_, j, sphere_B.p);
    r_tool_[j] = sphere_G.r;
    radii_[j] = sphere_G.r + sphere_B.r;
  }
  [[nodiscard]] bool full() const noexcept { return count_ == kCapacity; }

  /// Evaluates and empties; returns the smallest gap, or `minimum`.
  double flush(const PlacedBody& body, const ToolPlacement& tool, double minimum) noexcept {
    compute(body, tool);
    for (std::size_t j = 0; j < count_; ++j) {
      Contact& contact = *contact_[j];
      contact.gap = gap_[j];
      minimum = gap_[j] < minimum ? gap_[j] : minimum;
      if (distance_[j] < kSmallestLength) [[unlikely]] {
        const PrimitiveGap pair{Vector3::Zero(), distance_[j], gap_[j], 0.0};
        const Vector3 p_GC{p_GC_.x[j], p_GC_.y[j], p_GC_.z[j]};
        contact = make_contact(contact.key, pair, body_normal(pair, body.R_WB),
                               {rotate(tool.R_WG, p_GC), r_tool_[j], tool.p_WG});
        continue;
      }
      contact.nhat_OG_W = {nhat_.x[j], nhat_.y[j], nhat_.z[j]};
      contact.p_WC = {p_WC_.x[j], p_WC_.y[j], p_WC_.z[j]};
      contact.lambda = 0.0;
    }
    count_ = 0;
    return minimum;
  }

 private:
  using Numbers = std::array<double, kCapacity>;
  struct Points {
    Numbers x, y, z;
  };
  static void set(Points& points, std::size_t j, const Vector3& p) noexcept {
    points.x[j] = p.x();
    points.y[j] = p.y();
    points.z[j] = p.z();
  }
  /// One component of rotate(), summed in its order.
  static double row_times(const Matrix3& R, int row, double x, double y, double z) noexcept {
    return (R(row, 0) * x + R(row, 1) * y) + R(row, 2) * z;
  }

  // Without branches, on numbers of its own that no result can change, and not inlined, so that it
  // becomes vectors.
  [[gnu::noinline]] void compute(const PlacedBody& placed, const ToolPlacement& tool) noexcept {
    const Matrix3 R_BG = placed.R_BG;
    const Vector3 p_BG = placed.p_BG;
    const Matrix3 R_WB = placed.R_WB;
    const Matrix3 R_WG = tool.R_WG;
    const Vector3 p_WG = tool.p_WG;
    const std::size_t count = count_;
    for (std::size_t j = 0; j < count; ++j) {
      const double cx = p_GC_.x[j];
      const double cy = p_GC_.y[j];
      const double cz = p_GC_.z[j];
      const double x = (row_times(R_BG, 0, cx, cy, cz) + p_BG.x()) - p_B_.x[j];
      const double y = (row_times(R_BG, 1, cx, cy, cz) + p_BG.y()) - p_B_.y[j];
      const double z = (row_times(R_BG, 2, cx, cy, cz) + p_BG.z()) - p_B_.z[j];
      const double distance = std::sqrt((x * x + y * y) + z * z);
      const double inverse = 1.0 / distance;
      distance_[j] = distance;
      gap_[j] = distance - radii_[j];
      const double nx = row_times(R_WB, 0, x * inverse, y * inverse, z * inverse);
      const double ny = row_times(R_WB, 1, x * inverse, y * inverse, z * inverse);
      const double nz = row_times(R_WB, 2, x * inverse, y * inverse, z * inverse);
      nhat_.x[j] = nx;
      nhat_.y[j] = ny;
      nhat_.z[j] = nz;
      p_WC_.x[j] = (row_times(R_WG, 0, cx, cy, cz) - r_tool_[j] * nx) + p_WG.x();
      p_WC_.y[j] = (row_times(R_WG, 1, cx, cy, cz) - r_tool_[j] * ny) + p_WG.y();
      p_WC_.z[j] = (row_times(R_WG, 2, cx, cy, cz) - r_tool_[j] * nz) + p_WG.z();
    }
  }

  std::size_t count_ = 0;
  std::array<Contact*, kCapacity> contact_;
  Points p_GC_, p_B_, nhat_, p_WC_;  ///< m; axes of G, of B, of W
  Numbers r_tool_, radii_, distance_, gap_;
};

/// Evaluates pairs at one placement of the tool; pairs of the same body or leg of a string in a row
/// share where it is placed.
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
    const Capsule& segment = segment_.capsule_W;
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

  void place_segment(const ContactKey& key) noexcept {
    if (segment_of_ == key.obstacle && segment_.leg == key.obstacle_sphere) return;
    segment_ = segment_of(obstacles_, key.obstacle, key.obstacle_sphere);
    segment_.leg = key.obstacle_sphere;
    segment_of_ = key.obstacle;
    capsule_ = place_capsule(segment_.capsule_W, placement_.p_WG);
  }

  PrimitiveGap pair(const ContactKey& key, const Sphere& sphere_G) noexcept {
    const auto obstacle = static_cast<std::size_t>(key.obstacle);
    if (key.kind == ObstacleKind::kCapsule) {
      place_segment(key);
      PrimitiveGap gap = gap_to_capsule(rotate(placement_.R_WG, sphere_G.p), sphere_G.r, capsule_);
      gap.lambda = string_lambda(segment_, gap.lambda);
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
  AxisSegment segment_;
  PlacedCapsule capsule_;
  std::int32_t segment_of_ = -1;
};

}  // namespace

Contact evaluate_contact(const ContactKey& key, const SphereTreeView& tool, const Pose& X_WG,
                         const ObstaclesView& obstacles, const DisplacedParts& displaced) noexcept {
  return PairEvaluator(tool, X_WG, obstacles, displaced).contact(key);
}

void evaluate_contacts(const SphereTreeView& tool, const Pose& X_WG, const ObstaclesView& obstacles,
                       ContactSet& contacts, const DisplacedParts& displaced) noexcept {
  PairEvaluator evaluator(tool, X_WG, obstacles, displaced);
  const ToolPlacement placement = place_tool(X_WG);
  double minimum = std::numeric_limits<double>::infinity();
  BodyBatch batch;
  PlacedBody body{Matrix3::Zero(), Matrix3::Zero(), Vector3::Zero()};
  std::int32_t of_body = -1;
  for (Contact& contact : contacts.contacts) {
    const ContactKey& key = contact.key;
    if (key.kind != ObstacleKind::kBody || !displaced.parts.empty()) {
      contact = evaluator.contact(key);
      minimum = contact.gap < minimum ? contact.gap : minimum;
      continue;
    }
    const BodyView& view = obstacles.bodies[static_cast<std::size_t>(key.obstacle)];
    if (key.obstacle != of_body || batch.full()) {
      minimum = batch.flush(body, placement, minimum);
      if (key.obstacle != of_body) body = place_body(view.X_WB, placement);
      of_body = key.obstacle;
    }
    batch.add(contact, tree_sphere(tool, key.tool_sphere),
              tree_sphere(view.tree, key.obstacle_sphere));
  }
  contacts.minimum_gap = batch.flush(body, placement, minimum);
}

bool any_gap_below(double least, std::span<const std::int32_t> which, const ContactSet& contacts,
                   const SphereTreeView& tool, const Pose& X_WG, const ObstaclesView& obstacles,
                   const DisplacedParts& displaced) noexcept {
  PairEvaluator evaluator(tool, X_WG, obstacles, displaced);
  return std::any_of(which.begin(), which.end(), [&](std::int32_t c) {
    return evaluator.gap(contacts.contacts[static_cast<std::size_t>(c)].key) < least;
  });
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
