// See scene.h.
#include "core/scene/scene.h"

#include <algorithm>
#include <utility>

#include "core/collision/primitive_gap.h"
#include "core/scene/rest_places.h"
#include "core/scene/sagging_cable.h"

namespace hapticd {
namespace {

std::size_t memory_of(const SphereTree& tree) noexcept {
  return tree.nodes.size() * (sizeof(SphereTreeNode) + sizeof(NodeBox)) +
         tree.leaf_x.size() * 4 * sizeof(double);
}

}  // namespace

Scene::Scene(SceneDescription description) : description_(std::move(description)) {
  add_strings();
  add_lines();
  for (std::size_t group = 0; group * kCapsulesPerGroup < capsules_W_.size(); ++group) {
    groups_.push_back(group_capsules(capsules_W_, group));
  }
  for (const BodyDescription& body : description_.bodies) {
    bodies_.push_back({body.shape.tree->tree.view(), body.X_WB});
  }
  add_friction();
  add_rests();
  merge_parts();
}

void Scene::add_capsule(const Vector3& p_A, const Vector3& p_B, double radius, CapsuleOwner owner) {
  capsules_W_.push_back({p_A, p_B, radius});
  owners_.push_back(owner);
}

void Scene::add_strings() {
  for (std::size_t i = 0; i < description_.strings.size(); ++i) {
    for (const StringParameters& piece : cable_of(description_.strings[i])) {
      add_capsule(to_vector(piece.p_WA), to_vector(piece.p_WB), piece.radius,
                  {static_cast<std::int32_t>(i), true});
      strings_.push_back(derive_string(piece));
    }
  }
}

void Scene::add_lines() {
  for (std::size_t i = 0; i < description_.lines.size(); ++i) {
    const LineDescription& line = description_.lines[i];
    for (std::size_t k = 0; k + 1 < line.points_W.size(); ++k) {
      add_capsule(line.points_W[k], line.points_W[k + 1], line.radius,
                  {static_cast<std::int32_t>(i), false});
    }
  }
}

void Scene::add_friction() {
  for (const BodyDescription& body : description_.bodies) {
    body_friction_.push_back(body.friction_coefficient);
  }
  for (const CapsuleOwner& owner : owners_) {
    const auto index = static_cast<std::size_t>(owner.index);
    capsule_friction_.push_back(owner.is_string ? 0.0
                                                : description_.lines[index].friction_coefficient);
  }
  for (std::vector<double>* all : {&body_friction_, &capsule_friction_}) {
    if (std::all_of(all->begin(), all->end(), [](double mu) { return mu == 0.0; })) all->clear();
  }
}

void Scene::add_rests() {
  std::vector<std::int32_t> pieces(description_.strings.size(), 0);
  for (std::size_t piece = strings_.size(); piece-- > 0;) {
    pieces[static_cast<std::size_t>(owners_[piece].index)] = static_cast<std::int32_t>(piece);
  }
  rests_ = all_rests(description_, pieces);
}

void Scene::merge_parts() {
  for (const ToolDescription& tool : description_.tools) {
    MergedTool merged;
    std::vector<Sphere> leaves;
    for (std::size_t k = 0; k < tool.parts.size(); ++k) {
      const PartDescription& part = tool.parts[k];
      const SphereTreeView tree = part.shape.tree->tree.view();
      const Matrix3 R_GP = rotation_matrix(part.X_GP.q);
      for (std::size_t i = 0; i < tree.leaf_r.size(); ++i) {
        const Sphere leaf = tree.leaf(static_cast<std::int32_t>(i));
        leaves.push_back({rotate(R_GP, leaf.p) + part.X_GP.p, leaf.r});
        merged.part_of_sphere.push_back(static_cast<std::uint8_t>(k));
      }
      merged.parts.push_back(part.softness);
    }
    if (!any_soft({merged.parts, {}})) merged.parts.clear();
    merged.tree = build_sphere_tree(leaves);
    tools_.push_back(std::move(merged));
  }
}

ToolScene Scene::tool_scene(std::size_t tool) const noexcept {
  const MergedTool& merged = tools_[tool];
  ToolScene scene;
  scene.tool = merged.tree.view();
  scene.obstacles = {capsules_W_, bodies_, {}, groups_, box_of(groups_)};
  scene.stiffness = description_.tools[tool].coupling;
  scene.options = description_.contact;
  if (!description_.torque) scene.limits.torque = 0.0;
  scene.strings = strings_;
  scene.rests = rests_;
  scene.instrument = description_.instrument;
  scene.parts = {merged.parts, merged.part_of_sphere};
  scene.rigid_friction = {capsule_friction_, body_friction_};
  return scene;
}

OwnedSimulation Scene::simulate() const {
  std::vector<ToolScene> scenes;
  scenes.reserve(tools_.size());
  for (std::size_t tool = 0; tool < tools_.size(); ++tool) scenes.push_back(tool_scene(tool));
  return own_simulation(scenes);
}

OwnedSimulation Scene::simulate(std::size_t tool) const {
  const ToolScene scene = tool_scene(tool);
  return own_simulation({&scene, 1});
}

std::size_t Scene::tool_spheres(std::size_t tool) const noexcept {
  return tools_[tool].tree.leaf_r.size();
}

std::size_t Scene::body_spheres() const noexcept {
  std::size_t spheres = 0;
  for (const BodyView& body : bodies_) spheres += body.tree.leaf_r.size();
  return spheres;
}

std::size_t Scene::memory() const noexcept {
  std::size_t bytes = capsules_W_.size() * (sizeof(Capsule) + sizeof(CapsuleOwner)) +
                      groups_.size() * sizeof(CapsuleGroup) +
                      strings_.size() * (sizeof(StringConstants) + sizeof(PlayedString));
  bytes += rests_.size() * sizeof(StringRest);
  if (description_.instrument.modes > 0) bytes += strings_.size() * sizeof(WaveMemory);
  for (const MergedTool& tool : tools_) bytes += memory_of(tool.tree);
  for (const BodyDescription& body : description_.bodies) bytes += memory_of(body.shape.tree->tree);
  return bytes;
}

}  // namespace hapticd
