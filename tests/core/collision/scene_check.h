// A scene in both of its forms, the trees the product sees and the leaf spheres the oracle sees,
// and the comparison of find_contacts with the oracle.
#pragma once

#include <deque>
#include <vector>

#include "core/collision/query.h"
#include "core/modeling/sphere_tree.h"
#include "tests/support/contact_oracle.h"

namespace hapticd::test {

/// Owns one tool and its obstacles.
class CheckedScene {
 public:
  void set_tool(std::vector<Sphere> spheres_G);
  void add_body(std::vector<Sphere> spheres_B, const Pose& X_WB);

  [[nodiscard]] const std::vector<Sphere>& tool_spheres() const { return tool_spheres_; }
  [[nodiscard]] SphereTreeView tool() const { return tool_tree_.view(); }
  [[nodiscard]] ObstaclesView obstacles() const { return {capsules, body_views_}; }
  [[nodiscard]] OracleObstacles oracle_obstacles() const { return {capsules, oracle_bodies_}; }
  /// Longest length that enters a distance, m: the scale of rounding.
  [[nodiscard]] double extent(const Pose& X_WG) const;

  std::vector<Capsule> capsules;

 private:
  std::vector<Sphere> tool_spheres_;
  SphereTree tool_tree_;
  std::deque<std::vector<Sphere>> body_spheres_;
  std::deque<SphereTree> body_trees_;
  std::vector<BodyView> body_views_;
  std::vector<OracleBody> oracle_bodies_;
};

/// Rounding allowed between double and long double, relative to the extent.
inline constexpr double kRoundingTolerance = 1e-14;

/// find_contacts of `scene` at `X_WG` with leaf-level `options`: the set of pairs is the oracle's
/// (pairs within rounding of the margin may fall on either side), their gaps, normals, points and
/// lambdas too, and the minimum gap.
void check_against_oracle(const CheckedScene& scene, const Pose& X_WG, const QueryOptions& options);

}  // namespace hapticd::test
