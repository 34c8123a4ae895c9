// See scene_statics.h.
#include "tests/truth/scene_statics.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Gap of a sphere and a capsule, straight from the definition, m.
double gap_to(const Sphere& sphere, const Capsule& capsule) {
  const Vector3 axis = capsule.p_B - capsule.p_A;
  const double square = axis.squaredNorm();
  const double share =
      square > 0.0 ? std::clamp((sphere.p - capsule.p_A).dot(axis) / square, 0.0, 1.0) : 0.0;
  return (sphere.p - capsule.p_A - share * axis).norm() - capsule.r - sphere.r;
}

}  // namespace

SceneStatics::SceneStatics(const ToolScene& scene)
    : kt_(scene.stiffness.kt), length_(scene.stiffness.length) {
  for (std::size_t i = 0; i < scene.tool.leaf_r.size(); ++i) {
    tool_G_.push_back(scene.tool.leaf(static_cast<std::int32_t>(i)));
  }
  for (const BodyView& body : scene.obstacles.bodies) {
    for (std::size_t i = 0; i < body.tree.leaf_r.size(); ++i) {
      const Sphere leaf = body.tree.leaf(static_cast<std::int32_t>(i));
      bodies_W_.push_back({transform(body.X_WB, leaf.p), leaf.r});
    }
  }
  for (std::size_t i = 0; i < scene.obstacles.capsules_W.size(); ++i) {
    const Capsule& capsule = scene.obstacles.capsules_W[i];
    if (i >= scene.strings.size() || scene.strings[i].model != StringContact::kYielding) {
      lines_W_.push_back(capsule);
      continue;
    }
    const StringConstants& string = scene.strings[i];
    const double series = 1.0 / string.contact_stiffness - 1.0 / kt_;
    strings_.push_back({capsule, string.tension, string.axial_stiffness, std::max(0.0, series)});
    capsule_of_string_.push_back(static_cast<std::int32_t>(i));
  }
}

StaticRest SceneStatics::rest(const Pose& X_WH, const ContactState& from) const {
  // Of the tool, the spheres that have something within the range; of the bodies, what is near any.
  std::vector<Sphere> placed;
  Vector3 middle = Vector3::Zero();
  for (const Sphere& sphere : tool_G_) {
    placed.push_back({transform(from.X_WG, sphere.p), sphere.r});
    middle += placed.back().p / static_cast<double>(tool_G_.size());
  }
  double reach = 0.0;
  for (const Sphere& sphere : placed)
    reach = std::max(reach, (sphere.p - middle).norm() + sphere.r);
  std::vector<char> wanted(placed.size(), 0);
  std::vector<Sphere> bodies;
  for (const Sphere& body : bodies_W_) {
    if ((body.p - middle).norm() > reach + body.r + kRange) continue;
    bool near = false;
    for (std::size_t k = 0; k < placed.size(); ++k) {
      if ((body.p - placed[k].p).norm() - body.r - placed[k].r >= kRange) continue;
      wanted[k] = 1;
      near = true;
    }
    if (near) bodies.push_back(body);
  }
  StaticPlace place{from.X_WG, {}};
  std::vector<Capsule> lines;
  std::vector<StaticString> strings;
  const auto take = [&](const Capsule& capsule, double range) {
    bool near = false;
    for (std::size_t k = 0; k < placed.size(); ++k) {
      if (gap_to(placed[k], capsule) >= range) continue;
      wanted[k] = 1;
      near = true;
    }
    return near;
  };
  for (const Capsule& line : lines_W_) {
    if (take(line, kRange)) lines.push_back(line);
  }
  for (std::size_t s = 0; s < strings_.size(); ++s) {
    const Capsule& straight = strings_[s].straight_W;
    const TouchedString* held = nullptr;
    for (const TouchedString& hold : from.touched) {
      if (hold.yields && hold.bend.capsule == capsule_of_string_[s]) held = &hold;
    }
    const double bent = held != nullptr ? held->bend.u_W.norm() : 0.0;
    if (!take(straight, kRange + bent)) continue;
    strings.push_back(strings_[s]);
    // One that is not held has its vertex where the tool is nearest.
    const auto nearest =
        std::min_element(placed.begin(), placed.end(), [&](const Sphere& a, const Sphere& b) {
          return gap_to(a, straight) < gap_to(b, straight);
        });
    const StaticScene one{{}, {}, {}, {&strings_[s], 1}};
    place.vertices_W.push_back(free_place(one, {{1, 0, 0, 0}, nearest->p}).vertices_W.front());
    if (held != nullptr) {
      place.vertices_W.back() =
          straight.p_A + held->bend.lambda * (straight.p_B - straight.p_A) + held->bend.u_W;
    }
  }
  std::vector<Sphere> tool;
  for (std::size_t k = 0; k < tool_G_.size(); ++k) {
    if (wanted[k] != 0) tool.push_back(tool_G_[k]);
  }
  StaticScene scene{tool, bodies, lines, strings};
  scene.kt = kt_;
  scene.length = length_;
  return rest_from(scene, X_WH, place);
}

}  // namespace hapticd
