// A scene in both of its forms, the trees the product sees and the leaf spheres the oracle sees,
// and the comparison of find_contacts with the oracle.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "core/collision/query.h"
#include "core/tree/sphere_tree.h"
#include "tests/support/random.h"
#include "tests/truth/contact_oracle.h"

namespace hapticd::test {

/// A scene as plain lists, to be changed before it is built.
struct SceneParts {
  struct Body {
    std::vector<Sphere> spheres_B;
    Pose X_WB;
  };
  std::vector<Sphere> tool_G;
  std::vector<Capsule> capsules_W;
  std::vector<Body> bodies;
  Pose X_WG;
};

/// A tool of some 50 spheres among 5 strings and 3 bodies of up to 200 spheres, all within half a
/// metre; typically ten to a hundred pairs are nearer than 10 mm, some of them touch.
[[nodiscard]] SceneParts random_parts(SplitMix64& random);

/// Owns one tool and its obstacles.
class CheckedScene {
 public:
  CheckedScene() = default;
  explicit CheckedScene(const SceneParts& parts);

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

/// find_contacts of `scene`.
[[nodiscard]] std::unique_ptr<ContactSet> found_contacts(const CheckedScene& scene,
                                                         const Pose& X_WG,
                                                         const QueryOptions& options);

/// True when `a` comes before `b` by kind, obstacle, tool sphere, obstacle sphere.
[[nodiscard]] bool key_less(const ContactKey& a, const ContactKey& b);

/// The contacts of `set`, ordered by key.
[[nodiscard]] std::vector<Contact> by_key(const ContactSet& set);

/// True when every number of `a` and `b` has the same bits.
[[nodiscard]] bool same_bits(const Contact& a, const Contact& b);

/// find_contacts of `scene` at `X_WG` with leaf-level `options`: the set of pairs is the oracle's
/// (pairs within rounding of the margin may fall on either side), their gaps, normals, points and
/// lambdas too, and the minimum gap.
void check_against_oracle(const CheckedScene& scene, const Pose& X_WG, const QueryOptions& options);

/// Compares a result with the truth: `truth` holds all pairs below the margin and a little more.
/// The pairs found must be those below the margin, their gaps and the minimum gap equal.
void check_set(const ContactSet& set, OracleResult truth, const QueryOptions& options,
               double tolerance);

/// Compares contact `found`, of tool sphere `sphere_G` at `X_WG`, with the oracle's pair.
void check_contact(const Contact& found, const OracleContact& truth, const Sphere& sphere_G,
                   const Pose& X_WG, const ObstaclesView& obstacles, double tolerance);

}  // namespace hapticd::test
