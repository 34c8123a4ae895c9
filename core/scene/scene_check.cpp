// See scene_check.h.
#include "core/scene/scene_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>

#include "core/scene/rest_places.h"
#include "core/scene/sagging_cable.h"
#include "core/scene/scene.h"

namespace hapticd {
namespace {

/// Most spheres of a tool: ids of bounds stay within 32 bits (build_sphere_tree).
constexpr std::size_t kMaxToolSpheres = std::size_t{1} << 24U;
/// A tool may have as many parts as scene.proto says; the loop bears 256.
constexpr std::size_t kMaxParts = 32;

/// Range of the length that weighs rotation against translation, m: that of scene.proto.
constexpr double kMinLength = 0.003;
constexpr double kMaxLength = 1.0;
/// Stiffest over softest axis of translation, and of rotation, at most: forces are exact up to it
/// (tests/equilibrium). Larger: forces less exact.
constexpr double kMaxAxisRatio = 1000.0;
/// Two normals with less than this in common are of opposite sides of a string.
constexpr double kOppositeSides = -0.5;
/// Rounding of a ratio of numbers that a scene gives.
constexpr double kRatioRounding = 1e-12;

std::string indexed(const char* field, std::size_t i) {
  return std::string(field) + "[" + std::to_string(i) + "]";
}

class Findings {
 public:
  void fault(std::string path, std::string message, std::string remedy) {
    list_.push_back({false, std::move(path), std::move(message), std::move(remedy)});
  }
  void doubt(std::string path, std::string message, std::string remedy) {
    list_.push_back({true, std::move(path), std::move(message), std::move(remedy)});
  }
  void range(const std::string& owner, const std::optional<ParameterFault>& fault, bool doubt) {
    if (!fault) return;
    std::ostringstream message;
    message << fault->value << " is " << (doubt ? "doubtful: " : "not in ") << fault->range;
    const std::string path = owner.empty() ? fault->field : owner + "." + fault->field;
    list_.push_back({doubt, path, message.str(), fault->remedy});
  }
  void add(std::vector<SceneFinding> others) {
    std::move(others.begin(), others.end(), std::back_inserter(list_));
  }
  [[nodiscard]] bool any_fault() const noexcept {
    for (const SceneFinding& finding : list_) {
      if (!finding.doubt) return true;
    }
    return false;
  }
  [[nodiscard]] std::vector<SceneFinding> take() && { return std::move(list_); }

 private:
  std::vector<SceneFinding> list_;
};

/// Axes that differ: by no more than the program is exact for, and turning as heavy against moving
/// as where they are alike.
void check_axes(const std::string& path, const CouplingStiffness& stiffness, Findings& findings) {
  if (!stiffness.per_axis) return;
  const auto ratio = [&](const char* field, const Vector3& shares) {
    if (!(shares.minCoeff() * kMaxAxisRatio < 1.0 - kRatioRounding)) return;
    std::ostringstream message;
    message << "the stiffest axis is " << 1.0 / shares.minCoeff()
            << " times the softest, more than " << kMaxAxisRatio;
    findings.fault(path + field, message.str(), "Bring them closer to each other.");
  };
  ratio(".kt_w_n_per_m", stiffness.shares.along_W);
  ratio(".kr_g_n_m_per_rad", stiffness.shares.about_G);
}

/// Turning against moving, of the stiffest axes, in the range of length_m.
void check_length(const std::string& path, const CouplingStiffness& stiffness, Findings& findings) {
  if (stiffness.length >= kMinLength * (1.0 - kRatioRounding) &&
      stiffness.length <= kMaxLength * (1.0 + kRatioRounding)) {
    return;
  }
  std::ostringstream message;
  message << "the root of the stiffest rotation, " << stiffness.kr()
          << " N m/rad, over the stiffest translation, " << stiffness.kt << " N/m, is "
          << stiffness.length << " m, not in [0.003, 1], the range of length_m";
  const bool soft = stiffness.length < kMinLength;
  findings.fault(path + ".kr_g_n_m_per_rad", message.str(),
                 soft ? "Give a larger kr_g_n_m_per_rad, or a smaller kt."
                      : "Give a smaller kr_g_n_m_per_rad, or a larger kt.");
}

void check_tools(const SceneDescription& scene, Findings& findings) {
  std::set<std::uint32_t> ids;
  for (std::size_t i = 0; i < scene.tools.size(); ++i) {
    const ToolDescription& tool = scene.tools[i];
    const std::string path = indexed("tools", i);
    if (!ids.insert(tool.tool_id).second) {
      findings.fault(path + ".tool_id", std::to_string(tool.tool_id) + " is taken by another tool",
                     "Give every tool its own id.");
    }
    std::size_t spheres = 0;
    std::size_t soft = 0;
    for (std::size_t k = 0; k < tool.parts.size(); ++k) {
      const PartDescription& part = tool.parts[k];
      findings.range(path + "." + indexed("parts", k), check_part(part.softness), false);
      if (part.shape.tree) spheres += part.shape.tree->tree.leaf_r.size();
      if (part.softness.stiffness > 0.0) ++soft;
    }
    if (tool.parts.empty() || tool.parts.size() > kMaxParts) {
      findings.fault(path + ".parts", std::to_string(tool.parts.size()) + " is not in [1, 32]",
                     "Give the tool at least one part, and at most 32.");
    }
    if (spheres > kMaxToolSpheres) {
      findings.fault(path + ".parts", std::to_string(spheres) + " spheres are too many",
                     "Use coarser trees.");
    }
    if (soft > kMaxSoftParts) {
      findings.doubt(path + ".parts",
                     std::to_string(soft) + " parts are soft, of which " +
                         std::to_string(kMaxSoftParts) + " can yield at once",
                     "The others are rigid while that many are touched.");
    }
  }
}

void check_cable(const std::string& path, const StringDescription& string, Findings& findings) {
  if (string.sag == 0.0) return;
  const StringParameters& p = string.parameters;
  if (p.frequency > 0.0 || p.linear_density > 0.0) {
    findings.fault(path + ".sag_m", "a cable that sags has no pitch",
                   "Leave out sag_m, or frequency_hz and linear_density_kg_per_m.");
  }
  const double span = (to_vector(p.p_WB) - to_vector(p.p_WA)).norm();
  if (!(span > kMinString)) {
    findings.fault(path + ".sag_m", "a string without length cannot sag", "Leave out sag_m.");
  }
}

/// What a string may touch, and where.
struct Touched {
  std::string name;
  RestPlaces places;
};

std::vector<Touched> touched_by(const SceneDescription& scene, std::size_t i) {
  std::vector<Touched> touched;
  for (const std::size_t line : scene.strings[i].touched_lines) {
    touched.push_back({scene.lines[line].name, places_on_line(scene, i, line)});
  }
  for (const std::size_t body : scene.strings[i].touched_bodies) {
    touched.push_back({scene.bodies[body].name, places_on_body(scene, i, body)});
  }
  return touched;
}

/// A place on the other side of the string than what presses it, and whose.
struct Against {
  const std::string* name = nullptr;
  StringRest rest;
};

/// The nearest such place along the string; no name: there is none.
Against against(const Touched& thing, const std::vector<Touched>& all) {
  Against nearest;
  double least = 1.0;
  for (const StringRest& rest : thing.places.rests) {
    for (const Touched& other : all) {
      for (const StringRest& opposite : other.places.rests) {
        const double apart = std::abs(opposite.lambda - rest.lambda);
        if (apart >= least || rest.nhat_W.dot(opposite.nhat_W) > kOppositeSides) continue;
        least = apart;
        nearest = {&other.name, opposite};
      }
    }
  }
  return nearest;
}

/// A thing that the string is inside of: a capo presses it on something, else it is in the way.
void refuse_pressed(const std::string& path, const Touched& thing, const std::vector<Touched>& all,
                    Findings& findings) {
  std::ostringstream message;
  const Against held = against(thing, all);
  if (held.name == nullptr) {
    message << "at rest the string is " << -1e3 * thing.places.nearest_gap << " mm inside "
            << thing.name;
    findings.fault(path, message.str(), "Move one of them, or leave it out of touch.");
    return;
  }
  message << thing.name << " presses the string " << -1e3 * thing.places.nearest_gap
          << " mm towards " << *held.name << ", but a string is straight at rest";
  const Vector3& p_W = held.rest.p_W;
  std::ostringstream remedy;
  remedy << "Let the string end on " << *held.name << ", p_wa_m or p_wb_m: [" << p_W.x() << ", "
         << p_W.y() << ", " << p_W.z() << "], with the pitch of the part that is left, and leave "
         << thing.name << " out of touch.";
  findings.fault(path, message.str(), remedy.str());
}

/// What a string cannot lie on as the scene has it.
void check_touch(const SceneDescription& scene, std::size_t i, Findings& findings) {
  const StringDescription& string = scene.strings[i];
  const std::string path = indexed("strings", i) + ".touch";
  if (string.touched_lines.empty() && string.touched_bodies.empty()) return;
  if (string.sag > 0.0) {
    findings.fault(path, "a cable that sags lies on nothing", "Leave out touch, or sag_m.");
    return;
  }
  const StringConstants constants = derive_string(string.parameters);
  if (constants.model != StringContact::kYielding) {
    findings.doubt(path, "the string does not yield, so it never comes to lie on anything",
                   "Leave out touch, or choose another model.");
    if (!(constants.length > 0.0)) return;
  }
  const std::vector<Touched> all = touched_by(scene, i);
  for (const Touched& thing : all) {
    if (thing.places.nearest_gap < -kMaxRestOverlap) {
      refuse_pressed(path, thing, all, findings);
    } else if (thing.places.rests.empty()) {
      std::ostringstream message;
      message << thing.name << " is not within " << 1e3 * kRestReach << " mm of the string";
      findings.doubt(path, message.str(), "Move one of them, or leave it out of touch.");
    }
  }
}

std::size_t check_strings(const SceneDescription& scene, Findings& findings) {
  std::size_t pieces = 0;
  for (std::size_t i = 0; i < scene.strings.size(); ++i) {
    const StringDescription& string = scene.strings[i];
    const std::string path = indexed("strings", i);
    const auto fault = check_string(string.parameters);
    findings.range(path, fault, false);
    if (!fault) findings.range(path, doubt_string(string.parameters), true);
    check_cable(path, string, findings);
    if (!fault) check_touch(scene, i, findings);
    pieces += static_cast<std::size_t>(cable_pieces(string.sag));
    if (string.parameters.friction_coefficient > 0.0 && !scene.instrument.friction) {
      findings.doubt(path + ".friction_coefficient", "the scene models no friction",
                     "Add friction to the scene, or leave the coefficient out.");
    }
  }
  return pieces;
}

void check_rough(const SceneDescription& scene, Findings& findings) {
  if (scene.instrument.friction) return;
  const auto doubt = [&](const char* field, const auto& objects) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (objects[i].friction_coefficient == 0.0) continue;
      findings.doubt(indexed(field, i) + ".friction_coefficient", "the scene models no friction",
                     "Add friction to the scene, or leave the coefficient out.");
    }
  };
  doubt("bodies", scene.bodies);
  doubt("lines", scene.lines);
}

/// A tool that begins inside something is pushed out of it, and the player should know.
void check_start(const SceneDescription& description, Findings& findings) {
  const Scene scene(description);
  ContactSet contacts;
  for (std::size_t i = 0; i < description.tools.size(); ++i) {
    const ToolScene tool = scene.tool_scene(i);
    find_contacts({tool.tool, description.tools[i].X_WG}, tool.obstacles,
                  {.margin = tool.options.margin}, contacts);
    if (contacts.minimum_gap >= 0.0) continue;
    std::ostringstream message;
    message << "the tool begins " << -1e3 * contacts.minimum_gap << " mm inside something";
    findings.doubt(indexed("tools", i) + ".pose_wg", message.str(), "Start it in the open.");
  }
}

}  // namespace

std::vector<SceneFinding> check_couplings(const SceneDescription& scene) {
  Findings findings;
  for (std::size_t i = 0; i < scene.tools.size(); ++i) {
    const std::string path = indexed("tools", i) + ".coupling";
    check_axes(path, scene.tools[i].coupling, findings);
    check_length(path, scene.tools[i].coupling, findings);
  }
  return std::move(findings).take();
}

std::vector<SceneFinding> check_scene(const SceneDescription& scene) {
  Findings findings;
  if (scene.tools.empty()) {
    findings.fault("tools", "there is none", "Give at least one tool: a finger is one sphere.");
  }
  if (scene.tools.size() > kMaxTools) {
    findings.fault(
        "tools", std::to_string(scene.tools.size()) + " are more than " + std::to_string(kMaxTools),
        "Leave some out, or make several fingers one tool of several parts.");
  }
  check_tools(scene, findings);
  findings.add(check_couplings(scene));
  const std::size_t pieces = check_strings(scene, findings);
  check_rough(scene, findings);
  if (pieces > kMaxStrings) {
    findings.fault("strings",
                   std::to_string(pieces) + " strings and pieces of sagging cables are more than " +
                       std::to_string(kMaxStrings),
                   "Leave some out, or let fewer of them sag.");
  }
  findings.range("", check_options(scene.instrument), false);
  if (!findings.any_fault()) check_start(scene, findings);
  return std::move(findings).take();
}

}  // namespace hapticd
