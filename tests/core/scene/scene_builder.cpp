// See scene_builder.h.
#include "tests/core/scene/scene_builder.h"

namespace hapticd::test {

ShapeDescription shape_of(const std::vector<Sphere>& spheres) {
  MeasuredTree file;
  file.tree = build_sphere_tree(spheres);
  ShapeDescription shape;
  shape.exact = true;
  shape.tree = std::make_shared<const MeasuredTree>(std::move(file));
  return shape;
}

PartDescription part_of(const std::vector<Sphere>& spheres, const Pose& X_GP) {
  PartDescription part;
  part.name = "part";
  part.shape = shape_of(spheres);
  part.X_GP = X_GP;
  return part;
}

SceneDescription finger_scene(const Vector3& p_WG) {
  ToolDescription finger;
  finger.name = "finger";
  finger.parts.push_back(part_of({{{0.0, 0.0, 0.0}, 5e-3}}));
  finger.X_WG.p = p_WG;
  SceneDescription scene;
  scene.name = "finger";
  scene.tools.push_back(std::move(finger));
  return scene;
}

StringDescription string_between(const Vector3& p_WA, const Vector3& p_WB) {
  StringDescription string;
  string.name = "string";
  string.parameters.p_WA = to_array(p_WA);
  string.parameters.p_WB = to_array(p_WB);
  return string;
}

}  // namespace hapticd::test
