// A scene built: owner of all that the loop's views look at. Trees of a tool's parts are merged,
// lines and sagging cables become capsules, strings come first among them. Offline: built before
// the loop sees it, freed after; never changed.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/scene/owned_simulation.h"
#include "core/scene/scene_description.h"

namespace hapticd {

/// What a capsule of the scene is a piece of.
struct CapsuleOwner {
  std::int32_t index = 0;  ///< in SceneDescription::strings, or in lines
  bool is_string = false;
};

class Scene {
 public:
  /// Precondition: check_scene finds no fault in `description`.
  explicit Scene(SceneDescription description);
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene() = default;

  [[nodiscard]] const SceneDescription& description() const noexcept { return description_; }

  /// What one tool is rendered from; views memory of this scene.
  [[nodiscard]] ToolScene tool_scene(std::size_t tool) const noexcept;

  /// All tools among all obstacles, in their first state; views memory of this scene. Precondition:
  /// the scene has at most kMaxTools.
  [[nodiscard]] OwnedSimulation simulate() const;
  /// One tool alone.
  [[nodiscard]] OwnedSimulation simulate(std::size_t tool) const;

  /// Owners of the capsules that ContactKey::obstacle and StringTick::string number.
  [[nodiscard]] std::span<const CapsuleOwner> capsule_owners() const noexcept { return owners_; }

  /// Capsules that are strings or pieces of them; the first ones.
  [[nodiscard]] std::size_t string_pieces() const noexcept { return strings_.size(); }

  /// Leaves of a tool's merged tree, and of all bodies.
  [[nodiscard]] std::size_t tool_spheres(std::size_t tool) const noexcept;
  [[nodiscard]] std::size_t body_spheres() const noexcept;

  /// Memory of trees, capsules and strings, bytes.
  [[nodiscard]] std::size_t memory() const noexcept;

 private:
  /// A tool's parts in one tree.
  struct MergedTool {
    SphereTree tree;
    std::vector<ToolPart> parts;  ///< empty when all are rigid
    std::vector<std::uint8_t> part_of_sphere;
  };
  void add_capsule(const Vector3& p_A, const Vector3& p_B, double radius, CapsuleOwner owner);
  void add_strings();
  void add_lines();
  void add_friction();
  void add_rests();
  void merge_parts();

  SceneDescription description_;
  std::vector<MergedTool> tools_;
  std::vector<BodyView> bodies_;
  std::vector<Capsule> capsules_W_;
  std::vector<CapsuleGroup> groups_;
  std::vector<StringConstants> strings_;
  std::vector<CapsuleOwner> owners_;
  std::vector<StringRest> rests_;
  /// Coulomb coefficients of capsules and bodies; empty where all are smooth.
  std::vector<double> capsule_friction_;
  std::vector<double> body_friction_;
};

}  // namespace hapticd
