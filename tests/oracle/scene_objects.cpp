// See scene_objects.h.
#include "tests/oracle/scene_objects.h"

#include <algorithm>

namespace hapticd {

SceneObjects scene_objects(const Scene& scene) {
  const SceneDescription& description = scene.description();
  SceneObjects objects;
  for (const StringDescription& string : description.strings) objects.names.push_back(string.name);
  for (const LineDescription& line : description.lines) objects.names.push_back(line.name);
  for (const BodyDescription& body : description.bodies) {
    objects.of_body.push_back(objects.names.size());
    objects.names.push_back(body.name);
  }
  for (const CapsuleOwner& owner : scene.capsule_owners()) {
    const auto index = static_cast<std::size_t>(owner.index);
    objects.of_capsule.push_back(owner.is_string ? index : description.strings.size() + index);
  }
  return objects;
}

std::vector<double> object_gaps(const SceneObjects& objects, const ObstacleGaps& gaps) {
  std::vector<double> smallest(objects.names.size(), kFarthestGap);
  for (std::size_t i = 0; i < gaps.capsules.size(); ++i) {
    double& gap = smallest[objects.of_capsule[i]];
    gap = std::min(gap, gaps.capsules[i]);
  }
  for (std::size_t i = 0; i < gaps.bodies.size(); ++i) {
    smallest[objects.of_body[i]] = gaps.bodies[i];
  }
  return smallest;
}

std::vector<std::string> gap_columns(const SceneObjects& objects) {
  std::vector<std::string> columns;
  columns.reserve(objects.names.size());
  for (const std::string& name : objects.names) columns.push_back("gap_of_" + name + "_m");
  return columns;
}

}  // namespace hapticd
