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

/// A tool where it stands, and those of its spheres that have something within range.
class PlacedTool {
 public:
  PlacedTool(const std::vector<Sphere>& tool_G, const Pose& X_WG) : wanted_(tool_G.size(), 0) {
    for (const Sphere& sphere : tool_G) {
      spheres_W_.push_back({transform(X_WG, sphere.p), sphere.r});
      middle_ += spheres_W_.back().p / static_cast<double>(tool_G.size());
    }
    for (const Sphere& sphere : spheres_W_) {
      reach_ = std::max(reach_, (sphere.p - middle_).norm() + sphere.r);
    }
  }
  /// True where the capsule is within `range` of the tool; its spheres there are wanted.
  bool take(const Capsule& capsule, double range) {
    return take_by([&](const Sphere& sphere) { return gap_to(sphere, capsule) < range; });
  }
  /// Those of `all` that are within range.
  std::vector<Sphere> take_spheres(const std::vector<Sphere>& all) {
    std::vector<Sphere> near;
    for (const Sphere& body : all) {
      if ((body.p - middle_).norm() > reach_ + body.r + SceneStatics::kRange) continue;
      const bool taken = take_by([&](const Sphere& sphere) {
        return (body.p - sphere.p).norm() - body.r - sphere.r < SceneStatics::kRange;
      });
      if (taken) near.push_back(body);
    }
    return near;
  }
  [[nodiscard]] Vector3 nearest_to(const Capsule& capsule) const {
    return std::min_element(spheres_W_.begin(), spheres_W_.end(),
                            [&](const Sphere& a, const Sphere& b) {
                              return gap_to(a, capsule) < gap_to(b, capsule);
                            })
        ->p;
  }
  [[nodiscard]] std::vector<Sphere> taken(const std::vector<Sphere>& tool_G) const {
    std::vector<Sphere> out;
    for (std::size_t k = 0; k < tool_G.size(); ++k) {
      if (wanted_[k] != 0) out.push_back(tool_G[k]);
    }
    return out;
  }

 private:
  template <typename Near>
  bool take_by(const Near& near) {
    bool any = false;
    for (std::size_t k = 0; k < spheres_W_.size(); ++k) {
      if (!near(spheres_W_[k])) continue;
      wanted_[k] = 1;
      any = true;
    }
    return any;
  }

  std::vector<Sphere> spheres_W_;
  std::vector<char> wanted_;
  Vector3 middle_ = Vector3::Zero();
  double reach_ = 0.0;
};

/// How a string is bent, null where it is not held.
const StringBend* bend_of(const ContactState& state, std::int32_t capsule) {
  const StringBend* bend = nullptr;
  for (const TouchedString& hold : state.touched) {
    if (hold.yields && hold.bend.capsule == capsule) bend = &hold.bend;
  }
  return bend;
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
  PlacedTool tool(tool_G_, from.X_WG);
  const std::vector<Sphere> bodies = tool.take_spheres(bodies_W_);
  std::vector<Capsule> lines;
  for (const Capsule& line : lines_W_) {
    if (tool.take(line, SceneStatics::kRange)) lines.push_back(line);
  }
  StaticPlace place{from.X_WG, {}};
  std::vector<StaticString> strings;
  for (std::size_t s = 0; s < strings_.size(); ++s) {
    const Capsule& straight = strings_[s].straight_W;
    const StringBend* held = bend_of(from, capsule_of_string_[s]);
    if (!tool.take(straight, SceneStatics::kRange + (held != nullptr ? held->u_W.norm() : 0.0)))
      continue;
    strings.push_back(strings_[s]);
    if (held != nullptr) {
      place.vertices_W.emplace_back(straight.p_A + held->lambda * (straight.p_B - straight.p_A) +
                                    held->u_W);
      continue;
    }
    // One that is not held has its vertex where the tool is nearest.
    const StaticScene one{{}, {}, {}, {&strings_[s], 1}};
    place.vertices_W.push_back(
        free_place(one, {{1, 0, 0, 0}, tool.nearest_to(straight)}).vertices_W.front());
  }
  const std::vector<Sphere> spheres_G = tool.taken(tool_G_);
  StaticScene scene{spheres_G, bodies, lines, strings};
  scene.kt = kt_;
  scene.length = length_;
  return rest_from(scene, X_WH, place);
}

}  // namespace hapticd
