// A small scene that owns its memory, and the runs the rendering tests share: one tick, a press
// that is held, a straight stroke.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "core/contact/contact_problem.h"
#include "core/tree/sphere_tree.h"
#include "tests/truth/contact_oracle.h"

namespace hapticd::test {

class RenderingScene {
 public:
  explicit RenderingScene(std::vector<Sphere> tool_spheres);

  void add_body(std::vector<Sphere> spheres, const Pose& X_WB);
  /// What the code under test sees.
  [[nodiscard]] ObstaclesView obstacles() const { return {capsules_W, bodies_}; }
  [[nodiscard]] SphereTreeView tool() const { return tool_tree_.view(); }
  /// Smallest gap of the tool at X_WG by exhaustion, m.
  [[nodiscard]] long double true_gap(const Pose& X_WG) const;
  /// Smallest gap on the way from X_WF to X_WT by exhaustion, m; taken so densely that not even the
  /// thinnest obstacle can hide from the smallest sphere of the tool.
  [[nodiscard]] long double true_path_gap(const Pose& X_WF, const Pose& X_WT) const;
  /// The same while the strings held before or after move from one bend to the other, and soft
  /// parts from one displacement to the other.
  [[nodiscard]] long double true_path_gap(const ContactState& from, const ContactState& to) const;

  std::vector<Capsule> capsules_W;
  std::vector<Sphere> tool_spheres;
  /// Of the first capsules; without them all are rigid lines.
  std::vector<StringConstants> strings;
  InstrumentOptions instrument;
  /// Soft parts of the tool, and the part of each sphere; without them all is rigid.
  std::vector<ToolPart> parts;
  std::vector<std::uint8_t> part_of_sphere;
  [[nodiscard]] ToolParts tool_parts() const { return {parts, part_of_sphere}; }
  /// The tool's spheres in G where its soft parts have them.
  [[nodiscard]] std::vector<Sphere> displaced_spheres(const ContactState& state) const;

 private:
  [[nodiscard]] OracleObstacles truth() const { return {capsules_W, oracle_bodies_}; }
  [[nodiscard]] double oracle_spacing() const;

  SphereTree tool_tree_;
  // Deques: views into their elements stay valid while bodies are added.
  std::deque<std::vector<Sphere>> body_spheres_;
  std::deque<SphereTree> body_trees_;
  std::vector<BodyView> bodies_;
  std::vector<OracleBody> oracle_bodies_;
};

/// A tool in a scene with the state it carries from tick to tick.
struct ToolRun {
  const RenderingScene& scene;
  ContactState state;
  CouplingStiffness stiffness;
  ContactOptions options;
  std::int64_t work_budget = 0;
  ContactResult result;
  ContactInput asked;  ///< in the last tick
  std::unique_ptr<ContactProblem> problem = std::make_unique<ContactProblem>();

  ToolRun(const RenderingScene& owner, const Pose& X_WG) : scene(owner) { state.X_WG = X_WG; }

  [[nodiscard]] ContactInput input(const Pose& X_WH, double dt = 1e-3) const {
    ContactInput in{scene.tool(),  scene.obstacles(), X_WH,
                    stiffness,     options,           dt,
                    scene.strings, scene.instrument,  scene.tool_parts()};
    in.work_budget = work_budget;
    return in;
  }
  /// One tick of `dt` s towards X_WH.
  const ContactResult& tick(const Pose& X_WH, double dt = 1e-3);
  /// The same, and returns the smallest gap on the whole committed path by exhaustion, m.
  long double tick_along(const Pose& X_WH);
  /// `ticks` ticks at the same pose.
  const ContactResult& hold(const Pose& X_WH, int ticks);
};

/// Options of the reference: 400 linearisations per tick, 4 mrad, tolerance 1e-10 m.
[[nodiscard]] ContactOptions reference_options();

/// Pose at `p`, rotated by the rotation vector `phi`.
[[nodiscard]] Pose pose_at(const Vector3& p, const Vector3& phi = Vector3::Zero());

/// Pose at fraction `s` of the straight way from X_from to X_to (positions linear, rotation vector
/// linear).
[[nodiscard]] Pose between(const Pose& X_from, const Pose& X_to, double s);

}  // namespace hapticd::test
